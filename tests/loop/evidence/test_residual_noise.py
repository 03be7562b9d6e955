"""The noise at a frequency is known from the numbers that the columns left free there."""

import numpy as np
import pytest

from pysindy_evolve.loop.evidence.residual_noise import free_numbers, noise_power

N_SEGMENTS, N_FREQUENCIES = 16, 60


def white(*shape, seed=0):
    rng = np.random.default_rng(seed)
    return (rng.standard_normal(shape) + 1j * rng.standard_normal(shape)) / np.sqrt(2.0)


def slow_columns(n_columns, n_slow=2):
    """Columns that are nothing but slow, as powers of a position that is held mostly."""
    columns = np.zeros((n_columns, N_SEGMENTS, N_FREQUENCIES), dtype=complex)
    columns[:, :, :n_slow] = white(n_columns, N_SEGMENTS, n_slow, seed=1)
    return columns


def left_of(target, columns):
    """What least squares with real coefficients leaves."""
    flat = columns.reshape(len(columns), -1).view(float).T
    coef = np.linalg.lstsq(flat, target.reshape(-1).view(float), rcond=None)[0]
    return target - np.tensordot(coef, columns, axes=1)


def test_every_column_takes_half_a_complex_number():
    columns = white(7, N_SEGMENTS, N_FREQUENCIES)
    free = free_numbers(np.concatenate([columns, 3.0 * columns[:2]]))  # two are alike
    assert free.shape == (N_FREQUENCIES,)
    assert free.sum() == pytest.approx(N_SEGMENTS * N_FREQUENCIES - 3.5)


def test_without_columns_all_numbers_are_free():
    np.testing.assert_array_equal(free_numbers(white(0, N_SEGMENTS, 5)), N_SEGMENTS)


def test_slow_columns_take_what_is_slow():
    free = free_numbers(slow_columns(40))
    np.testing.assert_allclose(free[:2], N_SEGMENTS - 10.0, atol=3.0)
    np.testing.assert_allclose(free[2:], N_SEGMENTS)


@pytest.mark.parametrize("n_columns", [1, 40, 60, 64])
def test_white_noise_is_white_however_many_slow_columns_there_are(n_columns):
    """Sixty-four columns explain all of the two lowest frequencies, whatever it is."""
    columns, power = slow_columns(n_columns), []
    for seed in range(2, 42):
        left = left_of(white(N_SEGMENTS, N_FREQUENCIES, seed=seed), columns)
        power.append(noise_power(left, free_numbers(columns)))
    np.testing.assert_allclose(np.mean(power, axis=0), 1.0, rtol=0.1)


def test_a_spectrum_that_rises_is_followed():
    shape = np.linspace(1.0, 9.0, N_FREQUENCIES)
    left = shape * white(200, N_FREQUENCIES)
    power = noise_power(left, np.full(N_FREQUENCIES, 200.0))
    np.testing.assert_allclose(power[1:-8], shape[1:-8] ** 2, rtol=0.2)
