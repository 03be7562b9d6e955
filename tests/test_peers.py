"""The benchmark against peers: what counts as exact, and a peer that fails is a row."""

import importlib
import json
import sys
from pathlib import Path

import numpy as np
import pytest

PEERS = Path(__file__).parents[1] / "benchmarks" / "peers"


@pytest.fixture
def load(monkeypatch):
    monkeypatch.syspath_prepend(str(PEERS))
    names = ("run", "table", "peer_evolve")
    yield importlib.import_module
    for name in names:
        sys.modules.pop(name, None)


@pytest.fixture
def truth():
    x = np.random.default_rng(0).normal(size=(200, 2))
    return np.column_stack([x[:, 0], x[:, 1] ** 3]), np.array([-3.0, 0.5])


@pytest.mark.parametrize(
    ("extra", "scale", "exact"),
    [
        (0.0, (1.0, 1.0), "yes"),
        (0.0, (1.02, 1.0), "yes"),
        (0.1, (1.0, 1.0), "with offset"),
        (0.0, (1.0, 0.0), "no"),
        (np.sin(np.arange(200.0)), (1.0, 1.0), "no"),
        (np.nan, (1.0, 1.0), "invalid"),
    ],
)
def test_a_prediction_is_exact_if_all_true_terms_and_no_other_make_it(
    load, truth, extra, scale, exact
):
    theta, coef = truth
    said, off = load("run")._structure(theta, coef, theta @ (coef * scale) + extra)
    assert said == exact
    if exact in ("yes", "with offset"):
        assert off == pytest.approx(100.0 * max(abs(s - 1.0) for s in scale), abs=1e-6)
    else:
        assert off is None


def test_the_table_shows_ratios_to_ours_and_the_error_of_a_peer_that_failed(load):
    row = {
        "problem": "friction", "seed": 0, "exact": "yes", "coefficient_error": 0.1, "rows": 10,
        "validation_error": 0.2, "cpu": 2.0, "memory": 10.0, "data": 1.0, "load": 0.0,
        "lines": 7, "note": "as it comes",
    }  # fmt: skip
    rows = [
        row | {"method": "pysindy_evolve"},
        row | {"method": "slow", "cpu": 100.0, "memory": 25.0, "exact": "no"},
        {"method": "absent", "problem": "friction", "seed": 0, "error": "No module named 'absent'"},
    ]
    text = load("table").as_markdown(rows, ["frictionless", "friction"])
    assert "| slow [2] | 0 of 1 | 0.1 % | 0.2 % | 100.00 s | 50 | 25 MB | 2.5 | 7 |" in text
    assert "| absent [3] | failed: No module named 'absent' |" in text
    assert "2. slow: as it comes" in text
    assert "without friction" not in text


@pytest.mark.slow
def test_this_package_goes_through_a_run_of_the_benchmark(load, tmp_path):
    run = load("run")
    n = 2000
    t = np.arange(n) / 100.0
    q, v, zdd = np.random.default_rng(0).normal(size=(3, n))
    theta, coef = np.column_stack([v, q, q**3, zdd]), np.array([-2.0, -3.0, 4.0, -1.0])
    a = theta @ coef
    columns = np.column_stack([q, v, zdd])
    path = tmp_path / "data.npz"
    np.savez(
        path, t=t, x=columns[:, :2], u=columns[:, 2:], x_dot=np.column_stack([v, a]),
        theta=theta, coef=coef, a=a, columns=columns,
    )  # fmt: skip
    row = run.run("peer_evolve", "pysindy_evolve", str(path), 0)
    assert row["exact"] == "yes"
    assert row["coefficient_error"] < 1e-6
    assert row["memory"] >= 0.0
    assert json.loads(json.dumps(row)) == row
