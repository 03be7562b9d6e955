"""Derivatives, low-pass and integration against exact signals."""

import numpy as np
import pytest

from pysindy_evolve.signals import (
    differentiate,
    integrate,
    lowpass,
    noise_level,
)

from .closeness import DT


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
