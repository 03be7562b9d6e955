r"""Several measurements of one signal and its derivatives, fused for each frequency.

A signal q, its slope and so on are its *levels*. Their sine and cosine series have the same
coefficients, up to powers of the frequency, so each level is a measurement of each coefficient,
with a noise power of its own; they are averaged by the inverse of it. Levels that were computed
from each other share one noise and count once. What does not stand above the noise is left out
(Wiener's filter): what then is left of the noise does not go with the estimate.

======  ===================  ==========================================================
symbol  shape                meaning
======  ===================  ==========================================================
levels  (n, n_levels)        a signal and its successive derivatives, in units per sample
omega   (n - 1,)             frequency, radians per sample
spectra (n_levels, n - 1)    coefficients of the signal in a sine series, by each of the levels
power   (n_levels, n_bands)  power of the levels themselves, averaged in bands
noise   (n_levels, n_bands)  power of the white noise under it
======  ===================  ==========================================================
"""

from __future__ import annotations

import numpy as np
from numpy.polynomial import hermite_e
from scipy import fft

from ..checks import TINY
from .bands import AGREE, Bins, averaged, lowest_quarter, widening_edges
from .spectral import Array

__all__ = ["QUIET", "estimate"]

QUIET = 1e-4  # share of a column's RMS: less noise than this (80 dB) does no harm
NEAR = 4.0  # times the floor: below that a band holds mostly noise
FEW, SHARED = 0.1, 0.2  # share of the bands in which two levels differ by less than that share of
# their noise, if one was computed from the other
END = 0.02  # of the record is the widest bump at an end
WIDTHS = 4.0  # of a bump, after which it is over
SIGNS = (1.0, 1.0, -1.0, -1.0)  # of sin, its derivative and so on, in series of sines and cosines


def estimate(levels: Array) -> tuple[Array, Array, int]:
    """Estimate a signal from its levels: all levels of it, the noise left in each, the ends."""
    n, n_levels = levels.shape
    omega = np.pi * np.arange(1, n) / n
    known, ends = _trend_and_ends(levels[:, 0], n_levels)
    spectra = np.stack([_spectrum(y, m) for m, y in enumerate((levels - known).T)])
    edges = widening_edges(len(omega))
    noise, carrier = _noise_powers(spectra, omega, edges)
    weights = omega ** (2 * np.arange(n_levels)[:, None]) / np.repeat(noise, np.diff(edges), axis=1)
    # Levels computed from each other count once, with the noise of the one that was measured.
    total = np.zeros_like(omega)
    signal = np.zeros_like(omega)
    for group in np.unique(carrier):
        alike = np.flatnonzero(carrier == group)
        mean = (weights[alike] * spectra[alike]).sum(axis=0) / weights[alike].sum(axis=0)
        signal += weights[group] * mean
        total += weights[group]
    signal, left = signal / total, 1.0 / total
    passed = _wiener(signal**2, left, edges)
    result, error = np.empty_like(levels), np.empty(n_levels)
    for m in range(n_levels):
        result[:, m] = _series(signal * passed * omega**m, m)
        error[m] = np.sqrt(np.sum(left * passed * omega ** (2 * m)) / n)
    return result + known, error, ends


def _trend_and_ends(y: Array, n_levels: int) -> tuple[Array, int]:
    """Return what keeps a record from being a sine series, and its derivatives: (n, n_levels).

    A straight line, and at each end a bump as wide as the signal is slow, so that a sine series,
    which is zero at its ends, does not break off there.
    """
    n = len(y)
    s = np.arange(n)
    slope, offset = np.polyfit(s, y, 1)
    rest = y - offset - slope * s
    power = np.cumsum(_spectrum(rest, 0) ** 2)
    middle = np.pi * (1 + int(np.searchsorted(power, 0.5 * power[-1]))) / n
    width = min(1.0 / middle, END * n)
    known = np.zeros((n, n_levels))
    known[:, 0] = offset + slope * s
    known[:, 1:2] = slope
    for value, z in ((rest[0], s / width), (rest[-1], (s - s[-1]) / width)):
        bump = value * np.exp(-0.5 * z**2)
        for m in range(n_levels):  # derivatives of a Gaussian are Hermite polynomials times it
            known[:, m] += hermite_e.hermeval(z, [*[0.0] * m, (-1.0 / width) ** m]) * bump
    return known, int(np.ceil(WIDTHS * width))


def _spectrum(level: Array, m: int) -> Array:
    """Return the n - 1 coefficients of a level's sine series (m even) or cosine series (m odd).

    They are those of the signal: divided by omega^m, as derivatives of a sine series are series of
    cosines and sines by turns, whatever the ends of the record are.
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

    The difference of two measurements of one signal holds their noise and nothing else. If it is
    smaller than the noise of one of them, that one was computed from the other, or both from a
    third; if it is larger, one is no measurement of that signal, and the lower level is believed.
    """
    steps = omega ** np.arange(len(spectra))[:, None]
    power, size = averaged((spectra * steps) ** 2, edges), np.diff(edges)
    floors = np.array([lowest_quarter(row, size) for row in power])
    total = (power * size).sum(axis=1)
    share = size.sum() * floors / np.where(total > 0.0, total, 1.0)
    noise = np.repeat(floors[:, None], len(size), axis=1)
    carrier = np.arange(len(spectra))
    upper = len(spectra) - 1
    for lower in range(upper - 1, -1, -1):
        between = omega ** (2 * (upper - lower))
        implied = averaged(1.0 / between, edges) * noise[upper]
        found = averaged((spectra[lower] - spectra[upper]) ** 2 * steps[lower] ** 2, edges)
        ratio = found / np.maximum(noise[lower] + implied, np.finfo(float).tiny)
        if np.quantile(ratio, FEW) < SHARED:
            flat = [_flatness(power[m], floors[m], size, share[m]) for m in (lower, upper)]
            source = upper if flat[1] > flat[0] else lower
            carrier[(carrier == upper) | (carrier == lower)] = source
            upper = source
        else:
            apart = ratio > AGREE
            noise[upper, apart] = (found / averaged(1.0 / between, edges))[apart]
            upper = lower
    return noise, carrier


def _flatness(power: Array, floor: float, size: Bins, share: float) -> float:
    """Return the number of bins near the floor; none if it is too low to be noise at all."""
    return float(size[power < NEAR * floor].sum()) if share > QUIET**2 else 0.0


def _wiener(power: Array, noise: Array, edges: Bins) -> Array:
    """Return the share of the amplitude that is signal at each frequency."""
    share = 1.0 - 1.0 / np.maximum(averaged(power / noise, edges), TINY)
    middle = 0.5 * (edges[1:] + edges[:-1])
    return np.asarray(np.interp(np.arange(len(noise)), middle, np.clip(share, 0.0, 1.0)))
