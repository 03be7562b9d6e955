"""A derivative measured twice: the better of the two at each frequency."""

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from pysindy_evolve.signals import differentiate, fuse

DT = 1e-3


@pytest.fixture
def motion():
    """Time, state and derivative of a sweep, all clean."""
    t = np.arange(20_000) * DT
    phase = 2 * np.pi * (2.0 * t + 0.4 * t**2)
    speed = 2 * np.pi * (2.0 + 0.8 * t)
    return t, np.sin(phase), speed * np.cos(phase)


def error(found, truth):
    return np.std(found - truth) / np.std(truth)


def noise(size, seed, like):
    return size * np.std(like) * np.random.default_rng(seed).standard_normal(len(like))


@pytest.mark.parametrize("size", [0.05, 0.5])
def test_a_good_state_makes_a_noisy_derivative_ten_times_better(motion, size):
    t, x, x_dot = motion
    noisy = x_dot + noise(size, 0, x_dot)
    assert error(fuse(t, x, noisy), x_dot) < 0.11 * error(noisy, x_dot)


def test_a_jittering_record_gains_as_much_as_an_even_one(motion):
    t, x, x_dot = motion
    shift = 0.4 * DT * np.random.default_rng(5).uniform(-1.0, 1.0, len(t))
    shift[[0, -1]] = 0.0
    noisy = x_dot + noise(0.5, 0, x_dot)
    states, rates = (np.asarray(CubicSpline(t, c)(t + shift)) for c in (x, x_dot))
    fused = fuse(t + shift, states, rates + noisy - x_dot)
    assert error(fused, rates) < 0.11 * error(noisy, x_dot)


def test_a_good_derivative_is_left_alone_beside_a_noisy_state(motion):
    t, x, x_dot = motion
    assert error(fuse(t, x + noise(0.05, 1, x), x_dot), x_dot) < 1e-3


def test_the_result_is_better_than_both_where_each_is_good_at_some_frequencies(motion):
    t, x, x_dot = motion
    state, rate = x + noise(2e-3, 1, x), x_dot + noise(0.05, 2, x_dot)
    slope = differentiate(state, DT)
    fused = fuse(t, state, rate)
    assert error(fused, x_dot) < 0.75 * min(error(slope, x_dot), error(rate, x_dot))


def test_a_derivative_of_another_calibration_is_not_mixed_with_the_slope(motion):
    t, x, x_dot = motion
    rate = 1.3 * x_dot + noise(0.01, 3, x_dot)
    assert error(fuse(t, x, rate), 1.3 * x_dot) < 1.1 * error(rate, 1.3 * x_dot)


def test_each_column_is_fused_by_itself(motion):
    t, x, x_dot = motion
    rate = x_dot + noise(0.1, 4, x_dot)
    both = fuse(t, np.column_stack([x, x_dot]), np.column_stack([rate, rate]))
    assert both.shape == (len(t), 2)
    np.testing.assert_allclose(both[:, 0], fuse(t, x, rate), atol=1e-9 * np.std(x_dot))


def test_what_was_given_is_not_changed(motion):
    t, x, x_dot = motion
    kept = x_dot.copy()
    fuse(t, x, x_dot)
    np.testing.assert_array_equal(x_dot, kept)


def test_shapes_must_agree(motion):
    t, x, x_dot = motion
    with pytest.raises(ValueError, match=r"fuse\(x_dot=\.\.\.\) must be of the shape of x"):
        fuse(t, np.column_stack([x, x]), x_dot)
    with pytest.raises(ValueError, match="must be as long as t"):
        fuse(t[1:], x, x_dot)


def test_a_short_record_is_refused():
    t = np.arange(100.0)
    with pytest.raises(ValueError, match="must be at least 256 samples long; got 100"):
        fuse(t, t, t)
