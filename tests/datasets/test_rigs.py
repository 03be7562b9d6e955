"""The simulated rigs: the facts of the paper, the noise, and the drives of the demo."""

import numpy as np
import pytest

from pysindy_evolve.datasets.drives import friction_drive, nothing_missing
from pysindy_evolve.datasets.rigs import TIME_STEP, duffing, noisy
from pysindy_evolve.simulation import simulate


@pytest.fixture(scope="module")
def rig():
    """The friction rig, part of its length, 30 dB on the acceleration."""
    return duffing(friction=True, snr_db=30, n_samples=100_000)


@pytest.fixture(scope="module")
def whole_rig():
    """The friction rig, full length."""
    return duffing(friction=True, snr_db=30)


def ratio_db(measured, clean):
    return 10 * np.log10(np.mean(clean**2) / np.mean((measured - clean) ** 2))


class TestDuffing:
    @pytest.mark.slow
    def test_sizes_are_those_of_the_paper(self, whole_rig):
        free = duffing()
        assert (free.validation, free.train) == (slice(0, 16_000), slice(16_000, 123_000))
        parts = whole_rig.validation, whole_rig.train
        assert parts == (slice(0, 90_000), slice(90_000, 369_000))
        assert whole_rig.t[1] == TIME_STEP == 0.488e-3

    @pytest.mark.slow
    def test_both_parts_reach_the_large_motion_and_the_jump_is_in_the_record(self, whole_rig):
        assert np.abs(whole_rig.a[whole_rig.validation]).max() > 59
        assert np.abs(whole_rig.a[whole_rig.train]).max() > 59
        peaks = np.abs(whole_rig.q[:360_000]).reshape(-1, 1000).max(axis=1)
        jump = int(np.argmax(peaks[:-1] - peaks[1:]))
        assert 95 <= jump <= 115
        assert peaks[jump] > 1.4 * peaks[jump + 2]

    def test_motion_obeys_equation_7(self, rig):
        c, k, k3, mu1, mu2, b = 1.23, 714.60, 2.24e6, 4.11, 8.23e3, 1.04
        q, v = rig.q, rig.v
        a = -c * v - k * q - k3 * q**3 - (mu1 + mu2 * q**2) * np.sign(v) - b * rig.zdd
        moving = v != 0.0
        np.testing.assert_allclose(rig.a[moving], a[moving], atol=1e-9)
        assert np.all(np.abs(a[~moving]) <= mu1 + mu2 * q[~moving] ** 2 + 1e-9)
        assert np.all(rig.a[~moving] == 0.0)
        assert np.count_nonzero(~moving) > 500

    def test_motion_obeys_equation_3(self):
        free = duffing(n_samples=5_000)
        q, v = free.q, free.v
        a = (-1.8 * v - 487 * q - 1.07e6 * q**3) / 0.49 - free.zdd
        np.testing.assert_allclose(free.a, a, atol=1e-9)

    def test_acceleration_is_the_derivative_of_the_velocity(self):
        free = duffing(n_samples=20_000)
        slope = np.gradient(free.v, TIME_STEP)
        np.testing.assert_allclose(slope[10:-10], free.a[10:-10], atol=2e-3 * np.abs(free.a).max())

    def test_noise_is_on_the_target_only_at_its_ratio(self, rig):
        assert ratio_db(rig.x_dot[:, 1], rig.a) == pytest.approx(30, abs=0.1)
        assert np.array_equal(rig.x, np.column_stack([rig.q, rig.v]))
        assert np.array_equal(rig.u[:, 0], rig.zdd)

    def test_noise_may_be_on_all_signals(self):
        rig = duffing(snr_db=20, noise_on="all", n_samples=40_000, random_state=1)
        measured = (rig.x[:, 0], rig.x[:, 1], rig.x_dot[:, 1], rig.u[:, 0])
        for signal, clean in zip(measured, (rig.q, rig.v, rig.a, rig.zdd), strict=True):
            assert ratio_db(signal, clean) == pytest.approx(20, abs=0.2)
        assert np.array_equal(rig.x_dot[:, 0], rig.x[:, 1])

    def test_same_seed_gives_the_same_noise_and_another_seed_another(self):
        rigs = [duffing(snr_db=20, n_samples=2_000, random_state=seed) for seed in (3, 3, 4)]
        assert np.array_equal(rigs[0].x_dot, rigs[1].x_dot)
        assert not np.array_equal(rigs[0].x_dot, rigs[2].x_dot)

    def test_least_squares_on_the_true_terms_gives_the_coefficients_back(self, rig):
        theta = rig.equations.theta(rig.x, rig.u)
        moving = rig.v != 0.0
        fitted = np.linalg.lstsq(theta[moving], rig.x_dot[moving, 1], rcond=None)[0]
        np.testing.assert_allclose(fitted, rig.equations.coef[1], rtol=0.02)

    def test_accelerometers_measure_all_signals_by_integration(self):
        rig = duffing(friction=True, snr_db=40, accelerometers=True, n_samples=100_000)
        for part in (rig.train, rig.validation):
            for measured, clean in ((rig.x[:, 1], rig.v), (rig.x_dot[:, 1], rig.a)):
                error = np.std(measured[part] - clean[part]) / np.std(clean[part])
                assert 0.001 < error < 0.03
            assert np.corrcoef(rig.x[part, 0], rig.q[part])[0, 1] > 0.999
        assert rig.validation.start > 0

    def test_record_holds_one_part_under_its_names(self, rig):
        record = rig.record("train")
        assert record.n_samples == rig.train.stop - rig.train.start > 70_000
        assert (*record.states, *record.inputs) == rig.names
        assert np.array_equal(record.x_dot, rig.x_dot[rig.train])

    def test_experiments_have_the_coefficients_of_table_4(self):
        stiffness = [
            duffing(True, experiment=i, n_samples=500).equations.coef[1, 1] for i in (1, 2, 3)
        ]
        assert stiffness == [-691.92, -714.60, -716.11]

    def test_shared_motion_cannot_be_written_to(self, rig):
        with pytest.raises(ValueError, match="read-only"):
            rig.q[0] = 1.0

    @pytest.mark.parametrize(
        ("given", "match"),
        [
            ({"experiment": 4}, r"duffing\(experiment=...\) must be 1, 2 or 3; got 4"),
            ({"snr_db": np.inf}, r"duffing\(snr_db=...\) must be finite; got inf"),
            ({"noise_on": "x"}, r"duffing\(noise_on=...\) must be"),
            ({"n_samples": 3}, r"duffing\(n_samples=...\) must be at least 100; got 3"),
        ],
    )
    def test_bad_values_are_named(self, given, match):
        with pytest.raises(ValueError, match=match):
            duffing(**given)


def test_noise_of_a_ratio_is_relative_to_the_power_of_the_signal():
    signal = 3.0 * np.sin(np.arange(100_000) / 7.0)
    measured = noisy(signal, 20, np.random.default_rng(0))
    assert ratio_db(measured, signal) == pytest.approx(20, abs=0.1)
    assert noisy(signal, None, np.random.default_rng(0)) is signal


class TestDrives:
    def test_recorded_force_drives_the_axis_along_the_recorded_motion(self):
        drive = friction_drive()
        for record in (drive.train, drive.test):
            q = record.extras["q"]
            x = simulate(drive.equations, [q[0], 0.0], record.t, record.u)
            np.testing.assert_allclose(x[:, 0], q, atol=1e-3 * np.std(q))

    def test_axis_sticks_at_its_turning_points(self):
        v = friction_drive().train.extras["v"]
        assert 0.02 < np.mean(v == 0.0) < 0.3

    def test_encoder_rounds_and_is_noisy(self):
        record = friction_drive(noise=1e-5, resolution=1e-5).train
        steps = record.y[:, 0] / 1e-5
        np.testing.assert_allclose(steps, np.round(steps), atol=1e-6)
        assert np.std(record.y[:, 0] - record.extras["q"]) == pytest.approx(1.04e-5, rel=0.05)
        exact = friction_drive(noise=0.0, resolution=0.0).train
        assert np.array_equal(exact.y[:, 0], exact.extras["q"])

    def test_test_record_follows_another_reference(self):
        drive = friction_drive()
        assert abs(np.corrcoef(drive.train.u[:, 0], drive.test.u[:, 0])[0, 1]) < 0.9

    def test_nothing_missing_obeys_its_declared_model(self):
        drive = nothing_missing()
        names = [term.name(("q", "v", "F")) for term in drive.equations.terms]
        assert names == ["v", "F"]
        assert set(drive.declared) == {"q", "v"}

    def test_records_are_made_once_for_each_set_of_parameters(self):
        assert friction_drive() is friction_drive()
        assert friction_drive(random_state=1) is not friction_drive()

    @pytest.mark.parametrize(
        ("given", "match"),
        [
            ({"friction": -1.0}, r"friction_drive\(friction=...\) must be at least 0; got -1"),
            ({"noise": np.nan}, r"friction_drive\(noise=...\) must be at least 0; got nan"),
            ({"duration": 0.5}, r"friction_drive\(duration=...\) must be at least 1 s; got 0.5"),
        ],
    )
    def test_bad_values_are_named(self, given, match):
        with pytest.raises(ValueError, match=match):
            friction_drive(**given)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"snr_db": "a"}, r"duffing\(snr_db=...\) must be a number; got 'a'"),
        ({"n_samples": "a"}, r"duffing\(n_samples=...\) must be an integer; got 'a'"),
    ],
)
def test_options_of_another_type_are_named(wrong, message):
    with pytest.raises(TypeError, match=message):
        duffing(**wrong)


def test_an_unknown_part_of_the_record_is_named():
    with pytest.raises(ValueError, match=r'must be one of "train", "validation"; got \'foo\''):
        duffing(n_samples=400).record("foo")
