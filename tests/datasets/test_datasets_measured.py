"""Loaders of measured sets: shapes, splits, sources and errors."""

import itertools
import sys

import numpy as np
import pytest
from scipy.io import savemat

from pysindy_evolve import datasets
from pysindy_evolve.datasets import sources

SPLITS = {
    "load_emps": (["train"], ["pulses"]),
    "load_pendulum": (["first"], ["rest"]),
    "load_silverbox": (["train"], ["multisine", "arrow"]),
    "load_mr_damper": (["1", "3", "5", "7", "9"], ["2", "4", "6", "8", "10"]),
    "load_cascaded_tanks": (["estimation"], ["validation"]),
    "load_tclab": (["B"], ["E", "A"]),
    "load_cart": (["kP=2.5", "kP=5", "kP=10"], ["kP=20"]),
}
LOADERS = [*SPLITS, "load_ball_drops"]


@pytest.fixture
def nowhere(tmp_path, monkeypatch):
    """A machine without any measured record."""
    monkeypatch.setenv(sources.ENVIRONMENT_VARIABLE, str(tmp_path / "absent"))
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sources, "__file__", str(tmp_path / "a" / "b" / "c" / "d.py"))
    return tmp_path


@pytest.mark.parametrize("loader", LOADERS)
def test_every_record_is_complete_and_consistent(loader, data_dir):
    measured = getattr(datasets, loader)(data_dir)
    for record in (*measured.train, *measured.test):
        assert np.all(np.diff(record.t) > 0)
        assert record.y.shape == (record.t.size, len(record.outputs))
        assert np.isfinite(record.y).all()
        if record.u is None:
            assert record.inputs == ()
        else:
            assert record.u.shape == (record.t.size, len(record.inputs))
            assert np.isfinite(record.u).all()
        assert all(extra.shape == record.t.shape for extra in record.extras.values())
        assert measured[record.name] is record


@pytest.mark.parametrize("loader", SPLITS)
def test_split_is_the_published_one(loader, data_dir):
    measured = getattr(datasets, loader)(data_dir)
    train, test = SPLITS[loader]
    assert [record.name for record in measured.train] == train
    assert [record.name for record in measured.test] == test


def test_pendulum_is_cut_at_sixty_percent_without_a_gap(data_dir):
    measured = datasets.load_pendulum(data_dir)
    first, rest = measured["first"], measured["rest"]
    assert first.t.size == 33000
    assert rest.t[0] - first.t[-1] == pytest.approx(1e-3)


def test_silverbox_parts_have_the_published_lengths_and_share_one_input_mean(data_dir):
    measured = datasets.load_silverbox(data_dir)
    lengths = {record.name: record.t.size for record in (*measured.train, *measured.test)}
    assert lengths == {"train": 65062, "multisine": 21688, "arrow": 40475}
    assert abs(measured["train"].u.mean()) < 1e-3


def test_every_ball_drops_once_for_training_and_once_for_judging(data_dir):
    measured = datasets.load_ball_drops(data_dir)
    assert len(measured.train) == len(measured.test) == 11
    assert {record.name.split(",")[0] for record in measured.train} == {
        record.name.split(",")[0] for record in measured.test
    }
    assert measured["Golf Ball, drop 1"].constants["mass"] == pytest.approx(0.0459, abs=1e-4)


def test_cart_input_is_zero_until_the_control_starts(data_dir):
    record = datasets.load_cart(data_dir)["kP=5"]
    assert np.all(record.u[record.t < 1.0] == 0)
    after = record.t >= 1.0
    np.testing.assert_allclose(record.u[after], 5 * (0.2 - record.y[after]))


def test_unknown_record_name_lists_the_names(data_dir):
    with pytest.raises(KeyError, match=r"must be one of \['pulses', 'train'\]; got 'valid'"):
        datasets.load_emps(data_dir)["valid"]


def test_odebench_holds_63_systems_whose_states_match_their_equations(data_dir):
    systems = datasets.load_odebench(data_dir)
    assert [system.number for system in systems] == list(range(1, 64))
    for system in systems:
        assert system.initial_states.shape == (2, len(system.equations))


def test_a_folder_without_the_file_is_an_error_and_not_a_download(tmp_path):
    with pytest.raises(
        FileNotFoundError, match=r"folder=\.\.\.\) must name a folder that holds emps"
    ):
        datasets.load_emps(tmp_path)


def test_environment_variable_is_searched_when_no_folder_is_given(nowhere, data_dir, monkeypatch):
    monkeypatch.setenv(sources.ENVIRONMENT_VARIABLE, str(data_dir))
    assert datasets.load_cart()["kP=20"].t.size == 3968


@pytest.mark.parametrize("loader", ["load_ball_drops", "load_mr_damper", "load_odebench"])
def test_a_source_that_cannot_be_read_here_asks_for_the_folder(loader, nowhere):
    with pytest.raises(FileNotFoundError, match="got None"):
        getattr(datasets, loader)()


def test_without_pooch_the_error_names_the_pip_line(nowhere, monkeypatch):
    monkeypatch.setitem(sys.modules, "pooch", None)
    with pytest.raises(ImportError, match=r'pip install "pysindy-evolve\[data\]"'):
        datasets.load_emps()


def _publish(monkeypatch, files):
    """Serve local stand-ins in place of the public repositories."""
    monkeypatch.setattr(sources, "fetch", lambda repository, commit, path: files[path])


def test_emps_is_read_from_the_public_matlab_files(nowhere, data_dir, monkeypatch):
    local = datasets.load_emps(data_dir)
    files = {}
    for name, record in (("DATA_EMPS", local["train"]), ("DATA_EMPS_PULSES", local["pulses"])):
        path = nowhere / f"{name}.mat"
        savemat(
            path,
            {
                "t": record.t[:, None],
                "qm": record.y,
                "qg": record.extras["qref"][:, None],
                "vir": record.extras["u_V"][:, None],
                "gtau": 35.15065188,
            },
        )
        files[f"examples/EMPS/data/{name}.mat"] = path
    _publish(monkeypatch, files)
    downloaded = datasets.load_emps()
    np.testing.assert_allclose(downloaded["pulses"].u, local["pulses"].u, rtol=1e-12)


def test_pendulum_pieces_are_joined_from_the_public_matlab_file(nowhere, data_dir, monkeypatch):
    local = datasets.load_pendulum(data_dir)
    parts = (*local.train, *local.test)
    t = np.concatenate([part.t for part in parts])
    states = np.vstack(
        [
            np.concatenate([part.y[:, 0] for part in parts]),
            np.concatenate([part.extras["omega_given"] for part in parts]),
        ]
    )
    variables = {}
    for key, bounds in (("id", [0, 100, 20000, 30000]), ("vad", [30000, 40000, t.size])):
        times, pieces = np.empty(len(bounds) - 1, object), np.empty(len(bounds) - 1, object)
        for i, (start, stop) in enumerate(itertools.pairwise(bounds)):
            times[i], pieces[i] = t[start:stop, None], states[:, start:stop]
        variables |= {f"Time_{key}": times, f"Y_{key}": pieces}
    path = nowhere / "pendulum.mat"
    savemat(path, variables)
    name = "ParameterEstimation/SinglePendulum/SinglePendulumDataForParameterEstimation.mat"
    _publish(monkeypatch, {name: path})
    np.testing.assert_array_equal(datasets.load_pendulum()["rest"].y, local["rest"].y)


def test_tclab_is_read_from_the_public_tables(nowhere, data_dir, monkeypatch):
    monkeypatch.setattr(
        sources,
        "fetch",
        lambda repository, commit, path: (
            data_dir
            / "tclab"
            / {"196c74e": "rec_A.csv", "f3d31ff": "rec_B.csv", "f9a9d4b": "rec_E.csv"}[commit[:7]]
        ),
    )
    local = datasets.load_tclab(data_dir)
    np.testing.assert_array_equal(datasets.load_tclab()["E"].y, local["E"].y)


def test_cart_is_read_from_the_public_matlab_files(nowhere, data_dir, monkeypatch):
    local = datasets.load_cart(data_dir)
    files = {}
    for code, name in (("025", "2.5"), ("050", "5"), ("100", "10"), ("200", "20")):
        path = nowhere / f"{code}.mat"
        record = local[f"kP={name}"]
        savemat(path, {"t": record.t[:, None], "z": record.y})
        files[f"mfiles/p1c3/cdip_cart_pcont_data_kP_{code}_ref_02.mat"] = path
    _publish(monkeypatch, files)
    np.testing.assert_array_equal(datasets.load_cart()["kP=5"].u, local["kP=5"].u)


def test_tanks_are_read_from_the_public_table_by_column_name(nowhere, data_dir, monkeypatch):
    local = datasets.load_cascaded_tanks(data_dir)
    estimation, validation = local["estimation"], local["validation"]
    table = np.column_stack([estimation.u, validation.u, estimation.y, validation.y])
    path = nowhere / "tanks.csv"
    np.savetxt(path, table, delimiter=",", header="uEst,uVal,yEst,yVal", comments="", fmt="%.17g")
    _publish(monkeypatch, {"src/data/tanque.csv": path})
    np.testing.assert_array_equal(datasets.load_cascaded_tanks()["validation"].y, validation.y)


def test_silverbox_is_read_from_the_public_table_and_changed_content_is_refused(
    nowhere, data_dir, monkeypatch
):
    file = "silverbox/silverbox.npz"
    columns = sources.read_columns(file, data_dir)
    assert sources.digest_of({key: columns[key] for key in "uy"}) == sources.DIGESTS[file]
    path = nowhere / "other.csv"
    path.write_text("V1,V2\n0.1,0.2\n0.3,0.4\n", encoding="utf-8")
    _publish(monkeypatch, {"data/Silverbox/SNLS80mV.csv": path})
    with pytest.raises(ValueError, match="got a download with other numbers"):
        datasets.load_silverbox()
