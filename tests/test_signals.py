"""Records, preparation, filters and windows: exact where they can be, alike on every column."""

import copy
import pickle
import time
import warnings

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from pysindy_evolve.signals import (
    Record,
    Windows,
    choose_windows,
    differentiate,
    integrate,
    lowpass,
    noise_level,
    prepare,
    project,
    project_derivative,
    resample,
)

DT = 0.01


@pytest.fixture
def t():
    return np.arange(4000) * DT


@pytest.fixture
def rng():
    return np.random.default_rng(7)


@pytest.fixture
def driven(t):
    """Position, acceleration and force of q'' = -k q - c q' + F, in its steady state."""
    k, c = 30.0, 1.5
    q = np.zeros_like(t)
    a, force = np.zeros_like(t), np.zeros_like(t)
    for omega in (1.0, 4.3, 9.1, 17.0):
        wave = np.exp(1j * (omega * t + omega**2))
        response = 1.0 / (k - omega**2 + 1j * c * omega)
        q += (response * wave).real
        a += (-(omega**2) * response * wave).real
        force += wave.real
    return q, a, force, (k, c)


def nrmse(found, true):
    return np.sqrt(np.mean((found - true) ** 2)) / np.std(true)


# --- records ------------------------------------------------------------------------------


def test_record_promotes_one_dimension_to_a_column():
    record = Record(t=[0, 1, 2], x=[1, 2, 3], x_dot=[1, 1, 1], u=[0, 0, 1])
    assert record.x.shape == record.x_dot.shape == record.u.shape == (3, 1)
    assert (record.n_samples, record.n_states, record.n_inputs, record.dt) == (3, 1, 1, 1.0)
    assert len(record) == 3


def test_record_leaves_its_inputs_alone():
    t, x = np.arange(5.0), np.arange(5)
    before = x.copy()
    Record(t=t, x=x, x_dot=x)
    np.testing.assert_array_equal(x, before)
    assert x.dtype == before.dtype


def test_record_slices_every_column_alike(t):
    record = Record(t=t, x=np.sin(t), x_dot=np.cos(t), u=t, states=("q",), inputs=("F",))
    part = record[100:200]
    np.testing.assert_array_equal(part.t, t[100:200])
    np.testing.assert_array_equal(part.u[:, 0], t[100:200])
    assert (part.states, part.inputs) == (("q",), ("F",))


def test_split_holds_out_the_last_part(t):
    record = Record(t=t, x=t, x_dot=t)
    first, last = record.split(0.25)
    assert (first.n_samples, last.n_samples) == (3000, 1000)
    assert first.t[-1] < last.t[0]


def test_record_cannot_be_changed(t):
    record = Record(t=t, x=t, x_dot=t)
    with pytest.raises(AttributeError, match="cannot assign"):
        record.x = t


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"x": [1.0, np.nan, 3.0]}, r"Record\(x=...\) must be finite; got nan at sample 1"),
        ({"x_dot": [[1.0], [2.0], [np.inf]]}, r"Record\(x_dot=...\).* inf at sample 2, column 0"),
        ({"x": [1.0, 2.0]}, r"Record\(x=...\) must be as long as t; got 2 samples, t has 3"),
        ({"u": [1.0]}, r"Record\(u=...\) must be as long as t"),
        ({"t": [0.0, 2.0, 1.0]}, r"strictly increasing; got a step of -1 at sample 2"),
        ({"t": [0.0, 1.0, 1.0]}, r"strictly increasing; got a step of 0 at sample 2"),
        ({"t": np.zeros((3, 2))}, r"Record\(t=...\) must be 1-D"),
        ({"x": np.zeros((3, 2))}, r"Record\(x_dot=...\) must be of the shape of x"),
        ({"x": np.zeros((3, 1, 1))}, r"Record\(x=...\) must be 1-D or 2-D"),
        ({"x": np.zeros((3, 0))}, r"Record\(x=...\) must be 1-D or 2-D"),
        ({"x": [[1.0], [2.0, 3.0], [4.0]]}, r"Record\(x=...\) must be a rectangular array"),
        ({"x": [1e60, 2.0, 3.0]}, r"Record\(x=...\) must be at most 1e\+50 in size"),
        ({"t": [0.0, 1e-30, 2e-30]}, r"Record\(t=...\) must be in steps of 1e-20 to 1e\+20"),
        ({"states": ("a", "b")}, r"Record\(states=...\) must be 1 distinct names"),
        ({"inputs": ("F",)}, r"Record\(inputs=...\) must be 0 distinct names"),
    ],
)
def test_record_refuses_bad_values(change, message):
    good = {"t": [0.0, 1.0, 2.0], "x": [1.0, 2.0, 3.0], "x_dot": [1.0, 1.0, 1.0]}
    with pytest.raises(ValueError, match=message):
        Record(**{**good, **change})


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"x": ["a", "b", "c"]}, r"Record\(x=...\) must be real numbers"),
        ({"x": [1j, 2, 3]}, r"Record\(x=...\) must be real numbers"),
        ({"x": [None, 2, 3]}, r"Record\(x=...\) must be real numbers"),
        ({"states": "q"}, r"Record\(states=...\) must be a sequence of str"),
        ({"states": 3}, r"Record\(states=...\) must be a sequence of str"),
    ],
)
def test_record_refuses_bad_types(change, message):
    good = {"t": [0.0, 1.0, 2.0], "x": [1.0, 2.0, 3.0], "x_dot": [1.0, 1.0, 1.0]}
    with pytest.raises(TypeError, match=message):
        Record(**{**good, **change})


def test_record_refuses_odd_slices_and_splits(t):
    record = Record(t=t, x=t, x_dot=t)
    with pytest.raises(TypeError, match=r"rows=...\) must be a slice; got int"):
        record[3]
    with pytest.raises(ValueError, match="slice with step 1; got 2"):
        record[::2]
    with pytest.raises(ValueError, match="at least 2 samples long; got 0"):
        record[5:5]
    with pytest.raises(ValueError, match=r"fraction=...\) must be between 0 and 1; got 1.0"):
        record.split(1.0)
    with pytest.raises(ValueError, match="both parts keep 2 samples"):
        record[:5].split(0.1)


# --- filters ------------------------------------------------------------------------------


@pytest.mark.parametrize("order", [1, 2, 3])
def test_spectral_derivative_is_exact_at_nine_samples_per_period(t, order):
    omega = 2 * np.pi / (9 * DT)
    found = differentiate(np.sin(omega * t), DT, order=order, cutoff=30.0)
    true = omega**order * np.sin(omega * t + order * np.pi / 2)
    assert np.abs(found - true)[200:-200].max() < 5e-4 * omega**order


@pytest.mark.parametrize("method", ["fft", "savgol", "central"])
@pytest.mark.parametrize("cutoff", [None, 5.0])
def test_derivative_of_a_parabola_is_exact_inside(t, method, cutoff):
    found = differentiate(3.0 * t**2 - t, DT, order=2, method=method, cutoff=cutoff)
    np.testing.assert_allclose(found[500:-500], 6.0, rtol=2e-4)


def test_central_and_savgol_agree_with_the_spectral_derivative_on_slow_signals(t):
    x = np.sin(3 * t)
    for method in ("central", "savgol"):
        other = differentiate(x, DT, method=method)
        np.testing.assert_allclose(other[50:-50], 3 * np.cos(3 * t)[50:-50], atol=2e-3)


def test_lowpass_keeps_slow_drops_fast_and_shifts_nothing(t):
    slow, fast = np.sin(2 * t), np.sin(2 * np.pi * 20.0 * t)
    np.testing.assert_allclose(lowpass(slow, DT, 5.0), slow, atol=1e-3)
    assert np.abs(lowpass(fast, DT, 5.0)[100:-100]).max() < 1e-6
    half = lowpass(np.sin(2 * np.pi * 5.0 * t), DT, 5.0)[200:-200]
    np.testing.assert_allclose(half, 0.5 * np.sin(2 * np.pi * 5.0 * t)[200:-200], atol=1e-3)


def test_filters_keep_the_shape_and_the_input(t):
    x = np.stack([t, t**2], axis=1)
    before = x.copy()
    assert lowpass(x, DT, 5.0).shape == differentiate(x, DT).shape == (4000, 2)
    assert lowpass(t, DT, 5.0).shape == (4000,)
    np.testing.assert_array_equal(x, before)


def test_a_step_rings_little_and_briefly(t):
    step = (t > 20.0).astype(float)
    smooth = lowpass(step, DT, 5.0)
    assert np.ptp(smooth) < 1.2
    far = np.abs(t - 20.0) > 3.0 / 5.0
    assert np.abs(smooth - step)[far].max() < 2e-3


def test_integration_recovers_position_and_velocity_in_spite_of_drift(t):
    omega, t = 6.0, np.arange(20000) * DT
    a = -(omega**2) * np.sin(omega * t) + 0.5 + 0.02 * t
    q, v, band = integrate(a, DT, band=(0.1, 20.0))
    inside = slice(4000, -4000)
    np.testing.assert_allclose(q[inside], np.sin(omega * t)[inside], atol=2e-3)
    np.testing.assert_allclose(v[inside], omega * np.cos(omega * t)[inside], atol=1e-2)
    np.testing.assert_allclose(band[inside], -(omega**2) * np.sin(omega * t)[inside], atol=0.05)


@pytest.mark.parametrize("n", [500, 20000])
def test_noise_level_is_that_of_the_noise_under_a_signal(rng, n):
    x = np.sin(np.arange(n) / 20.0)
    noisy = np.stack([x + 0.02 * rng.standard_normal(n), 5 * rng.standard_normal(n)], axis=1)
    np.testing.assert_allclose(noise_level(noisy), [0.02, 5.0], rtol=0.3)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda x: lowpass(x, DT, 50.0), r"lowpass\(cutoff=...\) must be in \(0, 50\)"),
        (lambda x: lowpass(x, DT, 0.0), r"lowpass\(cutoff=...\) must be in \(0, 50\)"),
        (lambda x: lowpass(x, 0.0, 1.0), r"lowpass\(dt=...\) must be in"),
        (lambda x: lowpass(x[:3], DT, 1.0), r"lowpass\(x=...\) must be at least 4 samples"),
        (lambda x: differentiate(x, DT, order=0), r"order=...\) must be an integer from 1 to 8"),
        (lambda x: differentiate(x, DT, method="spline"), r'method=...\) must be one of "fft"'),
        (lambda x: integrate(x, DT, (5.0, 1.0)), r"band=...\) must be \(lowest, highest\)"),
        (lambda x: integrate(x, DT, (1e-3, 1.0)), r"band=...\) must be such that 2 periods"),
        (lambda x: integrate(x, DT, (1.0, 60.0)), r"integrate\(band=...\) must be in \(0, 50\)"),
        (lambda x: noise_level(x[:5]), r"noise_level\(y=...\) must be at least 16 samples"),
    ],
)
def test_filters_refuse_bad_values(t, call, message):
    with pytest.raises(ValueError, match=message):
        call(t)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda x: lowpass(x, "fast", 5.0), r"dt=...\) must be a number .*; got str"),
        (lambda x: differentiate(x, DT, order=1.5), r"order=...\) must be an integer .*got float"),
        (lambda x: differentiate(x, DT, method=3), r"method=...\) must be one of .*; got int"),
        (lambda x: integrate(x, DT, 5.0), r"band=...\) must be a pair of frequencies; got float"),
    ],
)
def test_filters_refuse_bad_types(t, call, message):
    with pytest.raises(TypeError, match=message):
        call(t)


# --- preparation --------------------------------------------------------------------------


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


# --- windows ------------------------------------------------------------------------------


@pytest.fixture
def windows():
    return Windows(width=20, stride=5)


def test_projection_is_the_weighted_mean_over_each_window(rng, windows):
    columns = rng.standard_normal((103, 3))
    found = project(columns, windows)
    assert found.shape == (windows.count(103), 3) == (17, 3)
    slow = [windows.weights @ columns[5 * i : 5 * i + 20] for i in range(17)]
    np.testing.assert_allclose(found, slow)
    np.testing.assert_allclose(project(columns[:, 0], windows), found[:, 0])
    np.testing.assert_allclose(project(np.arange(103.0), windows), windows.centers(103))


def test_projected_derivative_is_that_of_the_signal(t):
    windows = Windows(width=40, stride=10)
    x, x_dot = np.sin(2 * t), 2 * np.cos(2 * t)
    by_parts = project_derivative(x, windows, DT)
    np.testing.assert_allclose(by_parts, project(x_dot, windows), atol=2e-5)
    np.testing.assert_allclose(project_derivative(5 * t + 3, windows, DT), 5.0)


def test_projected_derivative_sees_through_noise_that_drowns_differences(t, rng):
    windows = Windows(width=200, stride=50)
    x = np.sin(2 * t) + 0.01 * rng.standard_normal(t.size)
    error = project_derivative(x, windows, DT) - project(2 * np.cos(2 * t), windows)
    assert np.std(error) < 0.01
    assert np.std(np.gradient(x, DT) - 2 * np.cos(2 * t)) > 0.5


def test_no_window_crosses_from_one_trajectory_to_the_next(rng, windows):
    first, second = rng.standard_normal((50, 2)), rng.standard_normal((37, 2))
    together = project(np.concatenate([first, second]), windows, lengths=[50, 37])
    apart = np.concatenate([project(first, windows), project(second, windows)])
    np.testing.assert_array_equal(together, apart)


def test_projection_is_fast(rng):
    columns = rng.standard_normal((250_000, 40))
    start = time.process_time()
    project(columns, Windows(width=24, stride=6))
    assert time.process_time() - start < 1.0


def test_windows_of_one_sample_leave_the_rows_alone(rng):
    columns = rng.standard_normal((10, 2))
    same = project(columns, Windows(width=1))
    np.testing.assert_array_equal(same, columns)
    assert same is not columns


def test_chosen_windows_average_noise_and_keep_the_signal(t, rng, driven):
    q, a, force, (k, c) = driven
    record = prepare(t, q + 2e-3 * q.std() * rng.standard_normal(t.size), force)
    windows = choose_windows(record)
    terms = np.column_stack([record.x, record.u])
    true = np.array([-k, -c, 1.0])

    def misfit(w):
        target = project(record.x_dot[:, 1], w)
        return nrmse(project(terms, w) @ true, target)

    assert windows.width > 4
    assert misfit(windows) < 0.7 * misfit(Windows(1))
    kept = project(record.x_dot[:, 1], windows)
    assert kept.std() > 0.7 * a.std()


def test_windows_can_be_chosen_for_records_without_preparation(t, rng):
    noisy = np.cos(t) + 0.05 * rng.standard_normal(t.size)
    records = [Record(t=t, x=np.sin(t), x_dot=noisy), Record(t=t, x=np.sin(t), x_dot=noisy)]
    assert 20 < choose_windows(records).width < 400
    still = Record(t=t, x=t, x_dot=np.ones_like(t))
    assert choose_windows(still) == Windows(1)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda w: Windows(width=0), r"Windows\(width=...\) must be an integer of at least 1"),
        (lambda w: project(np.ones(10), w), r"windows=...\) must be narrower than a trajectory"),
        (lambda w: project(np.ones(50), w, [20, 20]), r"lengths=...\) must be the samples of"),
        (lambda w: project(np.ones(50), w, [45, 5]), r"windows=...\) must be narrower than a"),
        (lambda w: project(np.ones(50) * np.nan, w), r"project\(columns=...\) must be finite"),
        (lambda w: project_derivative(np.ones(50), Windows(1), 1.0), "2 samples wide or more"),
        (lambda w: choose_windows([]), r"choose_windows\(records=...\) must be one record or more"),
    ],
)
def test_windows_refuse_bad_values(windows, call, message):
    with pytest.raises(ValueError, match=message):
        call(windows)


def test_windows_refuse_bad_types(windows):
    with pytest.raises(TypeError, match=r"Windows\(width=...\) must be an integer.*; got float"):
        Windows(width=2.5)
    with pytest.raises(TypeError, match=r"project\(windows=...\) must be Windows; got int"):
        project(np.ones(50), 5)
    with pytest.raises(TypeError, match=r"choose_windows\(records=...\) must be a Record"):
        choose_windows([1, 2])


# --- measured records ---------------------------------------------------------------------


def held_out_error(train, test, terms):
    """Derivative NRMSE %, windowed, of a least-squares fit on train judged on test."""
    windows = choose_windows(train)

    def sides(record):
        columns = np.column_stack([*terms(record), record.x_dot[:, 1]])
        return np.split(project(columns, windows), [-1], axis=1)

    theta, target = sides(train)
    coef = np.linalg.lstsq(theta, target, rcond=None)[0]
    theta, target = sides(test)
    return 100 * nrmse(theta @ coef, target)


def test_defaults_show_friction_and_offset_of_a_positioning_axis(data_dir):
    with np.load(data_dir / "emps" / "emps.npz") as d:
        train = prepare(d["train_t"], d["train_q"], d["train_force"])
        test = prepare(d["test_t"], d["test_q"], d["test_force"], **train.preparation.settings)
    declared = held_out_error(train, test, lambda r: [r.u, r.x[:, 1]])
    right = held_out_error(
        train, test, lambda r: [r.u, r.x[:, 1], np.sign(r.x[:, 1]), np.ones(len(r))]
    )
    assert declared > 20.0
    assert right < 8.0


def test_defaults_show_dry_friction_of_a_pendulum(data_dir):
    with np.load(data_dir / "pendulum_multiarm" / "single.npz") as d:
        t, angle = d["t"], d["theta"]
    n = int(0.6 * t.size)
    train = prepare(t[:n], angle[:n])
    test = prepare(t[n:], angle[n:], **train.preparation.settings)
    declared = held_out_error(train, test, lambda r: [np.sin(r.x[:, 0]), r.x[:, 1]])
    right = held_out_error(
        train, test, lambda r: [np.sin(r.x[:, 0]), r.x[:, 1], np.sign(r.x[:, 1])]
    )
    assert declared > 0.5
    assert right < 0.4


def test_defaults_show_the_hardening_spring_of_an_electronic_oscillator(data_dir):
    with np.load(data_dir / "silverbox" / "silverbox.npz") as d:
        y, u, dt = d["y"][40650:127400], d["u"][40650:127400] - d["u"].mean(), 1 / d["fs"]
    n = int(0.75 * y.size)
    times = np.arange(y.size) * dt
    train, test = (prepare(times[rows], y[rows], u[rows]) for rows in (slice(n), slice(n, None)))
    declared = held_out_error(train, test, lambda r: [r.u, *r.x.T])
    right = held_out_error(train, test, lambda r: [r.u, *r.x.T, r.x[:, 0] ** 3, np.ones(len(r))])
    assert declared > 3.0
    assert right < 1.33


# --- anything at all ----------------------------------------------------------------------

anything = st.one_of(
    st.none(),
    st.text(max_size=3),
    st.integers(-3, 200),
    st.floats(allow_nan=True, allow_infinity=True),
    st.lists(st.integers(0, 3), max_size=3),
)
arrays = hnp.arrays(
    dtype=st.sampled_from([np.float64, np.float32, np.int64, np.bool_]),
    shape=st.tuples(st.integers(0, 60)) | st.tuples(st.integers(20, 60), st.integers(0, 3)),
)
times = st.builds(
    lambda n, dt, jitter: dt * (np.arange(n) + jitter * np.sin(np.arange(n) ** 2)),
    st.integers(0, 60),
    st.floats(1e-25, 1e25),
    st.sampled_from([0.0, 0.001, 0.1, 0.6]),
)


@settings(max_examples=300, deadline=None)
@given(
    t=times | anything,
    y=arrays | anything,
    u=arrays | st.none() | anything,
    order=st.integers(1, 3) | anything,
    cutoff=st.just("auto") | anything,
    decimate=st.just("auto") | anything,
    method=st.sampled_from(["fft", "savgol", "central"]),
)
def test_any_input_ends_in_a_record_or_a_house_error(t, y, u, order, cutoff, decimate, method):
    if isinstance(t, np.ndarray) and isinstance(y, np.ndarray):
        t = t[: len(y)]
        y = y[: len(t)]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            record = prepare(t, y, u, order, cutoff, decimate, method)
        except (ValueError, TypeError) as error:
            message = str(error)
        else:
            message = "must be"
            project(record.x_dot, choose_windows(record))
    assert "must be" in message


@settings(max_examples=200, deadline=None)
@given(
    y=hnp.arrays(
        np.float64,
        st.tuples(st.integers(30, 80), st.integers(1, 2)),
        elements=st.floats(-1e50, 1e50),
    ),
    dt=st.floats(1e-19, 1e19),
    order=st.integers(1, 8),
    method=st.sampled_from(["fft", "savgol", "central"]),
)
def test_any_finite_record_is_prepared_or_refused(y, dt, order, method):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            record = prepare(dt * np.arange(len(y)), y, order=order, method=method)
        except ValueError as error:
            message = str(error)
        else:
            message = "must be"
            project(record.x_dot, choose_windows(record))
    assert "must be" in message
