"""Preparation: exact where it can be, alike on every column, the same again on a twin."""

import copy
import pickle
import time

import numpy as np
import pytest

from pysindy_evolve.signals import (
    prepare,
    resample,
)

from .closeness import DT, nrmse


def test_a_gap_is_said_to_be_better_cut_than_filled_with_a_straight_line():
    t = 0.005 * np.arange(2000)
    message = r"got a step of 0\.505 at sample 1000 where .* give the two parts as two records"
    with pytest.raises(ValueError, match=message):
        prepare(np.r_[t[:1000], t[1000:] + 0.5], np.sin(t))


@pytest.mark.parametrize("method", ["fft", "central", "savgol"])
@pytest.mark.parametrize("cutoff", ["auto", 8.0])
def test_a_linear_equation_still_holds_after_preparation(t, driven, method, cutoff):
    q, _, force, (k, c) = driven
    record = prepare(t, q, force, cutoff=cutoff, method=method)
    right = -k * record.x[:, 0] - c * record.x[:, 1] + record.u[:, 0]
    assert nrmse(right, record.x_dot[:, 1]) < (1e-3 if method == "fft" else 3e-2)


def test_every_column_is_filtered_alike_where_the_cutoff_bites(t, driven):
    q, _, force, (k, c) = driven
    record = prepare(t, q, force, cutoff=17.0 / (2 * np.pi), decimate=1)
    right = -k * record.x[:, 0] - c * record.x[:, 1] + record.u[:, 0]
    assert nrmse(right, record.x_dot[:, 1]) < 3e-3


@pytest.mark.parametrize(("noise", "limit"), [(0.0, 1e-3), (1e-3, 0.05), (5e-3, 0.12), (0.02, 0.3)])
def test_automatic_cutoff_finds_the_acceleration_under_position_noise(t, rng, driven, noise, limit):
    q, a, force, _ = driven
    noisy = q + noise * q.std() * rng.standard_normal(t.size)
    record = prepare(t, noisy, force)
    true = np.interp(record.t, t, a)
    assert nrmse(record.x_dot[:, 1], true) < limit
    if noise:
        assert record.preparation.noise[0] == pytest.approx(noise * q.std(), rel=0.2)


def test_automatic_cutoff_falls_with_noise(t, rng, driven):
    q = driven[0]
    error = q.std() * rng.standard_normal(t.size)
    cutoffs = [prepare(t, q + level * error).preparation.cutoff for level in (0, 1e-3, 3e-2)]
    assert cutoffs[0] > cutoffs[1] > cutoffs[2]
    assert cutoffs[0] == pytest.approx(1 / (3 * DT), rel=0.2)


def test_a_coarse_encoder_with_standstill_does_not_fool_the_cutoff(t):
    moving = np.where(t % 10 < 5, np.sin(2 * np.pi * t / 5.0) ** 3, 0.0)
    step = 0.02
    record = prepare(t, step * np.round(moving / step))
    assert record.preparation.cutoff < 10.0
    assert record.preparation.noise[0] == pytest.approx(step / np.sqrt(12), rel=0.5)


def test_states_are_ordered_by_signal_then_by_derivative(t):
    y = np.stack([np.sin(t), np.cos(2 * t)], axis=1)
    record = prepare(t, y, order=3)
    true = [np.sin(t), np.cos(t), -np.sin(t), np.cos(2 * t), -2 * np.sin(2 * t), -4 * np.cos(2 * t)]
    expected = np.stack([np.interp(record.t, t, column) for column in true], axis=1)
    assert record.x.shape == record.x_dot.shape == (record.n_samples, 6)
    np.testing.assert_allclose(record.x, expected, atol=5e-3)
    np.testing.assert_allclose(record.x_dot[:, :2], record.x[:, 1:3])


def test_first_order_states_are_the_signals_themselves(t):
    record = prepare(t, np.exp(-0.3 * t), np.stack([t, t**2], axis=1), order=1)
    assert (record.n_states, record.n_inputs) == (1, 2)
    np.testing.assert_allclose(record.x_dot, -0.3 * record.x, atol=2e-3)


@pytest.mark.parametrize("n", [50, 80])
@pytest.mark.parametrize("order", [1, 2])
def test_short_records_are_prepared(n, order):
    t = np.linspace(0.0, 5.0, n)
    record = prepare(t, np.exp(-t) * np.sin(3 * t), order=order)
    assert record.n_samples >= 0.85 * n
    true = [np.exp(-t) * (3 * np.cos(3 * t) - np.sin(3 * t))]
    true.append(np.exp(-t) * (-8 * np.sin(3 * t) - 6 * np.cos(3 * t)))
    assert nrmse(record.x_dot[:, -1], np.interp(record.t, t, true[order - 1])) < 0.02


@pytest.mark.parametrize("decimate", [1, 3, 7])
def test_decimation_keeps_the_values_at_the_kept_times(t, driven, decimate):
    q, _, force, _ = driven
    full = prepare(t, q, force, cutoff=4.0, decimate=1)
    thin = prepare(t, q, force, cutoff=4.0, decimate=decimate)
    rows = np.searchsorted(full.t, thin.t - 1e-9)
    np.testing.assert_allclose(full.t[rows], thin.t)
    scale = full.x_dot.std(axis=0)
    # Beyond three samples per period of the cutoff a trace of the filter's edge is left.
    np.testing.assert_allclose(
        thin.x / full.x.std(axis=0), full.x[rows] / full.x.std(axis=0), atol=2e-3
    )
    np.testing.assert_allclose(thin.x_dot / scale, full.x_dot[rows] / scale, atol=1e-2)


def test_automatic_decimation_keeps_eight_samples_per_period_of_the_cutoff(t):
    made = prepare(t, np.sin(t), cutoff=3.0).preparation
    assert made.decimation == 4
    assert made.trim == 50


@pytest.mark.parametrize("method", ["fft", "central", "savgol"])
def test_apply_repeats_the_preparation_exactly_and_linearly(t, rng, driven, method):
    q, _, force, _ = driven
    record = prepare(t, q + 1e-3 * rng.standard_normal(t.size), force, method=method)
    made = record.preparation
    again = made.apply(made.t, made.y, made.u)
    for name in ("t", "x", "x_dot", "u"):
        np.testing.assert_array_equal(getattr(again, name), getattr(record, name))
    other = rng.standard_normal((t.size, 1))
    both = made.apply(made.t, made.y + 2.0 * other, made.u)
    alone = made.apply(made.t, other, made.u)
    np.testing.assert_allclose(both.x_dot, record.x_dot + 2.0 * alone.x_dot, atol=1e-8)


def test_apply_of_a_slice_gives_the_same_rows(t, driven):
    q, _, force, _ = driven
    record = prepare(t, q, force)
    part = record[100:900][10:50]
    made = part.preparation
    np.testing.assert_array_equal(made.apply(made.t, made.y, made.u).x_dot, part.x_dot)
    np.testing.assert_array_equal(part.x_dot, record.x_dot[110:150])


def test_lowpass_of_the_preparation_is_what_the_input_went_through(t, driven):
    q, _, force, _ = driven
    record = prepare(t, q, force)
    np.testing.assert_allclose(record.preparation.lowpass(force), record.u[:, 0], atol=1e-12)
    np.testing.assert_allclose(record.preparation.lowpass(q), record.x[:, 0], atol=1e-12)


def test_apply_is_fast_enough_for_hundreds_of_twins(rng):
    t = np.arange(25000) * 1e-3
    made = prepare(t, np.cumsum(rng.standard_normal((25000, 1)), axis=0), t).preparation
    start = time.process_time()
    for _ in range(20):
        made.apply(made.t, made.y, made.u)
    assert time.process_time() - start < 1.0


def test_apply_refuses_other_samples(t):
    made = prepare(t, np.sin(t)).preparation
    with pytest.raises(ValueError, match=r"Preparation.apply\(y=...\) must be 4000 samples long"):
        made.apply(t, np.sin(t)[:-1])
    with pytest.raises(ValueError, match=r"Preparation.apply\(t=...\) must be sampled every 0.01"):
        made.apply(2 * t, np.sin(t))


def test_records_copy_and_pickle_with_their_preparation(t):
    record = prepare(t, np.sin(t), t)
    for twin in (pickle.loads(pickle.dumps(record)), copy.deepcopy(record)):
        np.testing.assert_array_equal(twin.x_dot, record.x_dot)
        made = twin.preparation
        np.testing.assert_array_equal(made.apply(made.t, made.y, made.u).x_dot, record.x_dot)


def test_preparation_says_how_it_was_done(t):
    text = repr(prepare(t, np.sin(t), cutoff=3.0).preparation)
    assert text.startswith("Preparation(order=2, method='fft', cutoff=3, decimation=4, trim=50")


def test_settings_prepare_a_record_of_another_length_alike(t, driven):
    q, _, force, _ = driven
    first = prepare(t[:2500], q[:2500], force[:2500], cutoff=4.0)
    second = prepare(t[2500:], q[2500:], force[2500:], **first.preparation.settings)
    assert second.preparation.settings == first.preparation.settings
    assert second.dt == pytest.approx(first.dt)


def test_prepare_never_writes_into_its_inputs(t):
    y, u = np.sin(t), np.cos(t)
    before = [a.copy() for a in (t, y, u)]
    prepare(t, y, u)
    for array, old in zip((t, y, u), before, strict=True):
        np.testing.assert_array_equal(array, old)


def test_jittering_time_is_interpolated(t, rng):
    jitter = t + 0.2 * DT * rng.uniform(-1, 1, t.size)
    record = prepare(jitter, np.sin(2 * jitter), cutoff=5.0)
    np.testing.assert_allclose(record.x_dot[:, 1], -4 * np.sin(2 * record.t), atol=0.02)


def test_a_gap_in_time_is_refused_and_resample_mends_it(t):
    holes = np.delete(t, np.arange(1000, 1005))
    with pytest.raises(ValueError, match=r"uniform within half.*0.06 at sample 1000.*resample\("):
        prepare(holes, np.sin(holes))
    even, y, u = resample(holes, np.sin(holes), np.cos(holes))
    np.testing.assert_allclose(even, t)
    np.testing.assert_allclose(y, np.sin(t), atol=1e-3)
    assert u.shape == t.shape
    assert prepare(even, y).n_samples > 3900


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"y": np.full(100, np.nan)}, r"prepare\(y=...\) must be finite; got nan at sample 0"),
        ({"u": np.r_[np.zeros(99), np.inf]}, r"prepare\(u=...\) must be finite.*sample 99"),
        ({"y": np.arange(99)}, r"prepare\(y=...\) must be as long as t; got 99 samples, t has 100"),
        ({"u": np.arange(9)}, r"prepare\(u=...\) must be as long as t; got 9 samples"),
        ({"y": np.ones((2, 100))}, r"got 2 samples, t has 100. Transpose it: a row is a sample."),
        ({"t": np.arange(100)[::-1]}, r"prepare\(t=...\) must be strictly increasing"),
        ({"t": np.arange(100) ** 2.0}, r"prepare\(t=...\) must be uniform within half"),
        ({"y": np.full(100, 3.0)}, r"prepare\(y=...\) must be changing; got 3 in all samples"),
        ({"t": [0, 1], "y": [0, 1]}, r"prepare\(t=...\) must be at least 24 samples long; got 2"),
        ({"order": 0}, r"prepare\(order=...\) must be an integer from 1 to 8; got 0"),
        ({"order": 9}, r"prepare\(order=...\) must be an integer from 1 to 8; got 9"),
        ({"cutoff": 0.5}, r"prepare\(cutoff=...\) must be in \(0, 0.5\)"),
        ({"cutoff": -1}, r"prepare\(cutoff=...\) must be in \(0, 0.5\)"),
        ({"cutoff": np.nan}, r"prepare\(cutoff=...\) must be in \(0, 0.5\)"),
        ({"cutoff": "low"}, r'prepare\(cutoff=...\) must be "auto", a number or None; got \'low\''),
        ({"decimate": 50}, r"prepare\(decimate=...\) must be at most \d+ here; got 50"),
        ({"decimate": 0}, r"prepare\(decimate=...\) must be an integer of at least 1"),
        ({"decimate": "all"}, r'prepare\(decimate=...\) must be "auto" or an integer'),
        ({"method": "magic"}, r'prepare\(method=...\) must be one of "fft", "savgol", "central"'),
    ],
)
def test_prepare_refuses_bad_values(change, message):
    t = np.arange(100.0)
    with pytest.raises(ValueError, match=message):
        prepare(**{"t": t, "y": np.sin(t / 5), **change})


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"y": ["a"] * 100}, r"prepare\(y=...\) must be real numbers; got list of dtype <U1"),
        ({"t": None}, r"prepare\(t=...\) must be real numbers; got NoneType of dtype object"),
        ({"order": 2.0}, r"prepare\(order=...\) must be an integer .*; got float"),
        ({"order": True}, r"prepare\(order=...\) must be an integer .*; got bool"),
        ({"cutoff": [1.0]}, r"prepare\(cutoff=...\) must be a number .*; got list"),
        ({"decimate": 1.5}, r"prepare\(decimate=...\) must be an integer .*; got float"),
        ({"method": None}, r"prepare\(method=...\) must be one of .*; got NoneType"),
    ],
)
def test_prepare_refuses_bad_types(change, message):
    t = np.arange(100.0)
    with pytest.raises(TypeError, match=message):
        prepare(**{"t": t, "y": np.sin(t / 5), **change})


@pytest.mark.parametrize("n", [1000, 5000])
def test_the_noise_of_a_sensor_is_known_without_bias(n):
    t, ratios = np.arange(n) * 0.01, []
    for seed in range(12):
        noise = 1e-2 * np.random.default_rng(seed).standard_normal(n)
        made = prepare(t, np.sin(4.0 * t) + 0.5 * np.sin(19.0 * t) + noise, order=2).preparation
        ratios.append(made.noise[0] / noise.std())
    assert np.mean(ratios) == pytest.approx(1.0, abs=0.025)


class TestLostMotion:
    t = np.arange(0.0, 20.0, 0.02)
    swing = np.sin(1.4 * t)

    @pytest.mark.parametrize("cutoff", [0.001, 0.02, 0.1])
    def test_a_cutoff_below_the_motion_is_warned_of(self, cutoff):
        """The equation of what was left looked fine, and was not that of the motion."""
        both = np.column_stack([self.swing, 0.05 * self.t])
        with pytest.warns(UserWarning, match=r"removes most of the motion in column 0 of y\."):
            prepare(self.t, both, cutoff=cutoff)

    @pytest.mark.parametrize("noise", [0.0, 0.1, 3.0])
    def test_noise_is_removed_without_a_word(self, noise):
        rng = np.random.default_rng(0)
        prepare(self.t, self.swing + noise * rng.normal(size=1000), cutoff=0.8)
        prepare(self.t, self.swing + noise * rng.normal(size=1000))
