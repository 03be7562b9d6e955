"""Derivatives that were measured twice: by themselves, and as the slope of their state.

======  ===============  ==========================================================
symbol  shape            meaning
======  ===============  ==========================================================
x       (n, k)           states
x_dot   (n, k)           their measured derivatives, units of x per unit of t
gap     (n, k)           slope of x less x_dot: the noise of both and nothing else
share   (n_freq, k)      weight of the slope at each frequency, between 0 and 1
======  ===============  ==========================================================
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy import fft
from scipy.interpolate import CubicSpline
from scipy.signal.windows import tukey

from .. import checks
from .bands import AGREE, geometric_edges
from .filters import differentiate
from .noise import floor, spectrum
from .sampling import mean_step, uniform
from .spectral import Array

FADE = 0.02  # share of the record, half at each end, over which the slope fades out
MIN_SAMPLES = 256  # samples; fewer do not give a usable spectrum


def fuse(t: ArrayLike, x: ArrayLike, x_dot: ArrayLike) -> Array:
    r"""Combine measured derivatives with the slope of the measured states, weighed by their noise.

    White noise of variance :math:`\sigma_x^2` on x is :math:`\omega^2 \sigma_x^2` on its slope, so
    at each frequency the mean of least variance is

    .. math:: \dot X_{fused} = \dot X + \frac{\sigma_{\dot x}^2}
              {\sigma_{\dot x}^2 + \omega^2 \sigma_x^2} (i \omega X - \dot X).

    Parameters
    ----------
    t : ndarray of shape (n_samples,)
        Times, uniform.
    x, x_dot : ndarray of shape (n_samples,) or (n_samples, n_states)
        Measured states and measured derivatives of them.

    Returns
    -------
    ndarray of the shape of x_dot
        Units of x per unit of t. No frequency is damped, so terms with jumps keep their edges.

    Raises
    ------
    ValueError
        If shapes differ, a value is not finite, t is not uniform, or there are fewer than 256
        samples.
    TypeError
        If an argument is not made of real numbers.

    Notes
    -----
    It helps where a derivative was measured by a noisier sensor than its state, as an acceleration
    beside a good velocity. At frequencies where the two differ by more than their noise, for
    example by the calibration of their sensors, x_dot is kept. The noise floors are those of
    `noise_level`. The cost is three FFTs for each column.

    Examples
    --------
    >>> import numpy as np
    >>> t = np.arange(4000) * 0.01
    >>> noisy = np.cos(t) + 0.1 * np.random.default_rng(0).standard_normal(4000)
    >>> bool(np.std(fuse(t, np.sin(t), noisy) - np.cos(t)) < 0.02)
    True
    """
    times = checks.times("fuse", t)
    states, rates = checks.columns("fuse", "x", x), checks.columns("fuse", "x_dot", x_dot)
    checks.same_length("fuse", t=times, x=states, x_dot=rates)
    if states.shape != rates.shape:
        advice = "Give one derivative per state."
        checks.refuse("fuse", "x_dot", "of the shape of x", f"shape {rates.shape}", advice)
    if len(times) < MIN_SAMPLES:
        got = f"{len(times)}"
        checks.refuse("fuse", "t", f"at least {MIN_SAMPLES} samples long", got, "Record longer.")
    grid, (even_x, even_rate) = uniform("fuse", times, states, rates)
    even_states, even_rates = np.asarray(even_x), np.asarray(even_rate)
    dt = mean_step(grid)
    window = tukey(len(grid), FADE)[:, None]
    gap = window * (differentiate(even_states, dt) - even_rates)
    gap_spectrum = fft.rfft(gap, axis=0)
    share = _share(even_states, even_rates, dt, np.abs(gap_spectrum) ** 2 / len(grid))
    fused = even_rates + fft.irfft(share * gap_spectrum, n=len(grid), axis=0)
    if even_rates is not rates:  # the samples lie between those of the grid
        fused = CubicSpline(grid, fused)(times)
    return fused.reshape(np.shape(x_dot))


def _share(states: Array, rates: Array, dt: float, gap_power: Array) -> Array:
    """Return the weight of the slope: that of least variance, or zero where the two disagree."""
    omega = 2.0 * np.pi * np.arange(len(gap_power))[:, None] / (len(states) * dt)
    noise_of_rate, noise_of_state = (floor(spectrum(columns, dt)[1]) for columns in (rates, states))
    noise_of_slope = omega**2 * noise_of_state
    expected = np.maximum(noise_of_rate + noise_of_slope, np.finfo(float).tiny)
    edges = geometric_edges(len(omega))
    found = np.add.reduceat(gap_power, edges[:-1], axis=0)
    ratio = found / np.add.reduceat(np.broadcast_to(expected, gap_power.shape), edges[:-1], axis=0)
    return noise_of_rate / expected * np.repeat(ratio <= AGREE, np.diff(edges), axis=0)
