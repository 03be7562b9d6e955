"""States freed from noise: what is estimated, what noise is left, and when nothing is done."""

import numpy as np
import pytest

from pysindy_evolve.signals import integrate
from pysindy_evolve.signals.improved import improved
from pysindy_evolve.signals.smoothing import is_noisy, smooth_states
from pysindy_evolve.signals.time_step import time_step

DT = 0.01


@pytest.fixture
def motion():
    """Position, velocity, acceleration and input of a driven swing, clean: (n, 4)."""
    t = np.arange(8000) * DT
    phase = 2 * np.pi * (0.3 * t + 0.01 * t**2)
    q = np.sin(phase) + 0.3 * np.sin(2.1 * t) + 0.02 * t
    v = np.gradient(q, DT, edge_order=2)
    a = np.gradient(v, DT, edge_order=2)
    return np.column_stack([q, v, a, np.cos(phase)])


def measured(motion, ratio, seed=0):
    """Add white noise to all columns; return x (q, v, u) and x_dot (v, a)."""
    rng = np.random.default_rng(seed)
    q, v, a, u = (motion + ratio * motion.std(axis=0) * rng.standard_normal(motion.shape)).T
    return np.column_stack([q, v, u]), np.column_stack([v, a])


def errors(estimate, motion):
    return np.std(estimate - motion[:, [0, 1, 3]], axis=0)


def test_a_third_of_the_noise_is_left_at_most_and_its_size_is_known(motion):
    x, x_dot = measured(motion, 0.03)
    smoothed = smooth_states(x, x_dot)
    left = errors(smoothed.x, motion)
    assert np.all(left < 0.3 * errors(x, motion))
    np.testing.assert_allclose(smoothed.noise, left, rtol=0.6)


def test_integrated_accelerations_are_seen_to_share_one_noise(motion):
    rng = np.random.default_rng(1)
    noise = 0.03 * motion[:, 2].std() * rng.standard_normal(len(motion))
    q, v, a = integrate(motion[:, 2] + noise, DT, (0.1, 45.0))
    clean = integrate(motion[:, 2], DT, (0.1, 45.0))
    smoothed = smooth_states(np.column_stack([q, v]), np.column_stack([v, a]))
    left = (smoothed.x - np.column_stack(clean[:2]))[1000:-1000].std(axis=0)
    as_measured = np.std((np.column_stack([q, v]) - np.column_stack(clean[:2]))[1000:-1000], axis=0)
    assert np.all(left < as_measured)
    assert np.all(smoothed.noise > 0.3 * left)


def test_clean_states_and_rows_in_no_order_are_left_as_they_are(motion):
    x, x_dot = measured(motion, 0.0)
    x_dot[:, 1] += 0.1 * np.random.default_rng(0).standard_normal(len(x))
    assert not is_noisy(x)
    assert smooth_states(x, x_dot) is None
    x, x_dot = measured(motion, 0.03)
    shuffled = np.random.default_rng(0).permutation(len(x))
    assert is_noisy(x[shuffled])
    assert smooth_states(x[shuffled], x_dot[shuffled]) is None


def test_short_records_are_left_as_they_are(motion):
    x, x_dot = measured(motion, 0.03)
    assert smooth_states(x[:200], x_dot[:200]) is None


def test_sampling_time_is_found_from_states_and_derivatives(motion):
    x, x_dot = measured(motion, 0.03)
    assert time_step(x[:, :2], x_dot) == pytest.approx(DT, rel=2e-3)
    assert time_step(x[:, :2], x_dot[:, ::-1]) is None
    assert time_step(x[:, :2], -x_dot) is None


def test_states_whose_derivatives_do_not_vary_have_no_sampling_time_to_be_found():
    x = np.column_stack([np.linspace(0.0, 1.0, 500), np.linspace(3.0, 1.0, 500)])
    assert time_step(x, np.tile([2.0, -4.0], (500, 1))) is None


def test_estimate_does_not_depend_on_units(motion):
    x, x_dot = measured(motion, 0.03)
    plain = smooth_states(x, x_dot)
    scaled = smooth_states(1e3 * x, 1e3 * x_dot)
    np.testing.assert_allclose(scaled.x, 1e3 * plain.x, rtol=1e-6, atol=1e-3)
    np.testing.assert_allclose(scaled.noise, 1e3 * plain.noise, rtol=1e-5)


def of_enzyme(rng, n):
    x = rng.uniform(0.2, 3.0, (n, 1))
    return x, -2.0 * x / (0.5 + x)


def of_drift(rng, n):
    x = rng.normal(size=(n, 2))
    return x, np.column_stack([1.0 + 0.3 * x[:, 1], 0.5 - 0.2 * x[:, 0]])


@pytest.mark.parametrize("rows", [of_enzyme, of_drift])
def test_rows_in_no_order_are_left_alone_whatever_the_mean_of_the_derivative(rows):
    for seed in range(20):
        assert smooth_states(*rows(np.random.default_rng(seed), 1000)) is None


@pytest.mark.parametrize("n", [400, 500, 700, 1000])
def test_a_map_is_no_time_series(n):
    x = np.empty((n + 1, 1))
    x[0] = 0.4
    for k in range(n):
        x[k + 1] = 3.9 * x[k] * (1.0 - x[k])
    assert smooth_states(x[:-1], x[1:]) is None


def test_the_next_value_of_a_slow_turn_is_no_slope():
    turns = np.arange(1001) * np.pi / 2.0  # four rows each: the next value leads as a slope does
    x = np.cos(turns)[:, None] + 0.05 * np.random.default_rng(0).standard_normal((1001, 1))
    assert smooth_states(x[:-1], x[1:]) is None


def two_rates(rate, ratio, seed=2):
    """A slow and a fast decay in 6000 rows: clean states, and noisy states and derivatives."""
    t = np.arange(6000) * 1e-3
    fast = np.exp(-rate * t)
    x = np.column_stack([np.exp(-0.5 * t) + 0.2 * fast, fast])
    x_dot = np.column_stack([-0.5 * x[:, 0] + (0.1 - 0.2 * rate) * fast, -rate * fast])
    rng = np.random.default_rng(seed)
    noisy_x, noisy_x_dot = (y + ratio * y.std(0) * rng.normal(size=y.shape) for y in (x, x_dot))
    return x, noisy_x, noisy_x_dot


@pytest.mark.parametrize("ratio", [3e-4, 3e-3, 3e-2])
@pytest.mark.parametrize("rate", [10.0, 30.0, 100.0])
def test_a_fast_transient_at_the_start_is_not_smoothed_away(rate, ratio):
    clean, x, x_dot = two_rates(rate, ratio)
    smoothed = smooth_states(x, x_dot)
    assert time_step(x, x_dot) == pytest.approx(1e-3, rel=5e-3)
    for rows in (slice(0, 100), slice(100, None)):
        worse = np.std((smoothed.x - clean)[rows], axis=0) / np.std((x - clean)[rows], axis=0)
        assert np.all(worse < 1.5)
    assert np.mean(smoothed.improved) > 0.8


def test_noise_that_grows_along_the_record_is_nearly_all_removed():
    rng = np.random.default_rng(3)
    noise = rng.standard_normal((4000, 1)) * np.linspace(0.1, 2.0, 4000)[:, None]
    trusted, _ = improved(noise, np.zeros_like(noise))
    assert trusted.mean() > 0.95
