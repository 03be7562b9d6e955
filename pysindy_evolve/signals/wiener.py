r"""Measurements of a signal and of its derivatives, combined at each frequency (Wiener filter).

A signal q, its slope and so on are its *levels*. Their sine and cosine series have the same
coefficients, up to powers of the frequency. So each level measures each coefficient, with its own
noise power, and they are averaged with the inverse noise power as weight. Levels that were computed
from each other share one noise and count once. Then each frequency is weighed by the share of its
power that is signal, so that the remaining error is not correlated with the estimate.

======  ===================  ==========================================================
symbol  shape                meaning
======  ===================  ==========================================================
levels  (n, n_levels)        a signal and its successive derivatives, in units per sample
omega   (n - 1,)             frequency, radians per sample
spectra (n_levels, n - 1)    sine coefficients of the signal, as measured by each level
power   (n_levels, n_bands)  power of the levels themselves, averaged in bands
noise   (n_levels, n_bands)  power of the white noise under it
======  ===================  ==========================================================
"""

from __future__ import annotations

import numpy as np
from numpy.polynomial import hermite_e
from scipy import fft
from scipy.integrate import cumulative_trapezoid

from ..checks import TINY
from .bands import AGREE, Bins, averaged, lowest_quarter, widening_edges
from .spectral import Array

MAX_QUIET_NOISE = 1e-4  # share of a column's RMS: less noise than this (80 dB) does no harm
NEAR_FLOOR = 4.0  # times the floor; a band with less power is mostly noise
# Two levels were computed from each other if, in a share QUANTILE of the bands, the power of their
# difference is less than the share SHARED_NOISE of that of their noise.
QUANTILE, SHARED_NOISE = 0.1, 0.2
WIDEST = 0.02  # share of the record; largest width of the bump at an end
BUMP_WIDTHS = 4.0  # widths after which a bump is over
SIGNS = (1.0, 1.0, -1.0, -1.0)  # of the successive derivatives of sin: sin, cos, -sin, -cos


def estimate(levels: Array) -> tuple[Array, Array, int]:
    """Estimate a signal from its measured levels.

    Returns the estimated levels, (n, n_levels), the standard deviation of the noise left in each,
    and the number of rows at each end where the estimate is worse.
    """
    n, n_levels = levels.shape
    omega = np.pi * np.arange(1, n) / n
    removed, ends = _trend_and_ends(levels)
    spectra = np.stack([_spectrum(y, m) for m, y in enumerate((levels - removed).T)])
    edges = widening_edges(len(omega))
    noise, carrier = _noise_powers(spectra, omega, edges)
    weights = omega ** (2 * np.arange(n_levels)[:, None]) / np.repeat(noise, np.diff(edges), axis=1)
    # Levels computed from each other count once, with the noise of the measured one.
    total = np.zeros_like(omega)
    signal = np.zeros_like(omega)
    for group in np.unique(carrier):
        sharing = np.flatnonzero(carrier == group)
        mean = (weights[sharing] * spectra[sharing]).sum(axis=0) / weights[sharing].sum(axis=0)
        signal += weights[group] * mean
        total += weights[group]
    signal, noise_power = signal / total, 1.0 / total
    gain = _wiener(signal**2, noise_power, edges)
    result, noise_left = np.empty_like(levels), np.empty(n_levels)
    for m in range(n_levels):
        result[:, m] = _series(signal * gain * omega**m, m)
        noise_left[m] = np.sqrt(np.sum(noise_power * gain * omega ** (2 * m)) / n)
    return result + removed, noise_left, ends


def _trend_and_ends(levels: Array) -> tuple[Array, int]:
    """Return what to subtract before a sine series, (n, n_levels), and the rows of a bump.

    It is a straight line, and at each end a Gaussian bump, which makes the rest zero there as a
    sine series is. The bump is wider for a slower signal.
    """
    n, n_levels = levels.shape
    rows = np.arange(n)
    slope, offset = np.polyfit(rows, levels[:, 0], 1)
    trend = np.zeros_like(levels)
    trend[:, 0] = offset + slope * rows
    trend[:, 1:2] = slope
    detrended = levels - trend
    power = np.cumsum(_spectrum(detrended[:, 0], 0) ** 2)
    median_omega = np.pi * (1 + int(np.searchsorted(power, 0.5 * power[-1]))) / n
    width = min(1.0 / median_omega, WIDEST * n)
    first = _first_value(detrended, width)
    backward = detrended[::-1] * (-1.0) ** np.arange(n_levels)  # each derivative turns its sign
    last = _first_value(backward, width)
    removed = trend
    for value, z in ((first, rows / width), (last, (rows - rows[-1]) / width)):
        bump = value * np.exp(-0.5 * z**2)
        for m in range(n_levels):  # derivatives of a Gaussian are Hermite polynomials times it
            removed[:, m] += hermite_e.hermeval(z, [*[0.0] * m, (-1.0 / width) ** m]) * bump
    return removed, int(np.ceil(BUMP_WIDTHS * width))


def _first_value(levels: Array, width: float) -> float:
    """Return the value at the first row: each of the next rows, less the integral, measures it."""
    near = levels[: int(width) + 1]
    if levels.shape[1] == 1:
        return float(near[0, 0])
    return float(np.mean(near[:, 0] - cumulative_trapezoid(near[:, 1], initial=0.0)))


def _spectrum(level: Array, m: int) -> Array:
    """Return the n - 1 coefficients of a level's sine series (m even) or cosine series (m odd).

    Divided by omega^m they are the sine coefficients of the signal itself, as the derivatives of a
    sine series alternate between cosine and sine series.
    """
    n = len(level)
    omega = np.pi * np.arange(1, n) / n
    if m % 2:
        found = fft.dct(level, norm="ortho")[1:]
    else:
        found = fft.dst(level, norm="ortho")[:-1]
    return np.asarray(found * SIGNS[m % 4] / omega**m)


def _series(coefficients: Array, m: int) -> Array:
    """Sum a sine series (m even) or cosine series (m odd) of n - 1 coefficients: (n,)."""
    if m % 2:
        return np.asarray(fft.idct(np.r_[0.0, SIGNS[m % 4] * coefficients], norm="ortho"))
    return np.asarray(fft.idst(np.r_[SIGNS[m % 4] * coefficients, 0.0], norm="ortho"))


def _noise_powers(spectra: Array, omega: Array, edges: Bins) -> tuple[Array, Bins]:
    """Return the noise power of each level in each band, and the level whose noise it shares.

    The difference of two measurements of one signal is their noise alone. If it is smaller than
    that, one was computed from the other, or both from a third. If it is larger, one of them does
    not measure the signal, and the lower derivative is trusted.
    """
    factors = omega ** np.arange(len(spectra))[:, None]
    power, size = averaged((spectra * factors) ** 2, edges), np.diff(edges)
    floors = np.array([lowest_quarter(row, size) for row in power])
    total = (power * size).sum(axis=1)
    share = size.sum() * floors / np.where(total > 0.0, total, 1.0)
    noise = np.repeat(floors[:, None], len(size), axis=1)
    carrier = np.arange(len(spectra))
    upper = len(spectra) - 1
    for lower in range(upper - 1, -1, -1):
        omega_powers = omega ** (2 * (upper - lower))
        implied = averaged(1.0 / omega_powers, edges) * noise[upper]
        observed = averaged((spectra[lower] - spectra[upper]) ** 2 * factors[lower] ** 2, edges)
        ratio = observed / np.maximum(noise[lower] + implied, np.finfo(float).tiny)
        if np.quantile(ratio, QUANTILE) < SHARED_NOISE:
            n_bins = [_n_noise_bins(power[m], floors[m], size, share[m]) for m in (lower, upper)]
            source = upper if n_bins[1] > n_bins[0] else lower
            carrier[(carrier == upper) | (carrier == lower)] = source
            upper = source
        else:
            disagrees = ratio > AGREE
            noise[upper, disagrees] = (observed / averaged(1.0 / omega_powers, edges))[disagrees]
            upper = lower
    return noise, carrier


def _n_noise_bins(power: Array, floor: float, size: Bins, share: float) -> float:
    """Return the number of bins with power near the floor; zero if the floor is no noise."""
    return float(size[power < NEAR_FLOOR * floor].sum()) if share > MAX_QUIET_NOISE**2 else 0.0


def _wiener(power: Array, noise: Array, edges: Bins) -> Array:
    """Return the gain of the Wiener filter at each frequency: the share of the power of signal."""
    share = 1.0 - 1.0 / np.maximum(averaged(power / noise, edges), TINY)
    middle = 0.5 * (edges[1:] + edges[:-1])
    return np.asarray(np.interp(np.arange(len(noise)), middle, np.clip(share, 0.0, 1.0)))
