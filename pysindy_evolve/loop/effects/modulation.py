"""Waves times a signal: the frequency at which the strength of a term varies, in time or space.

At this frequency, the signal times a sine and a cosine explains most of a residual, beside the
signal itself.

References
----------
Zechmeister and Kuerster 2009, DOI 10.1051/0004-6361:200811296: the periodogram of a residual over
the values, with their squares as weights.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import fft
from scipy.stats import binned_statistic

from ...checks import TINY
from ...terms import Sum
from .lines import vertex

ROUGHNESS = 2  # grid points per frequency that a record resolves; tuned afterwards
PUMPED = 0.1  # share of a residual's square that a wave times a term must explain
SINGULAR = 0.01  # determinant below which cosine and sine are the same on a record


@dataclass(frozen=True, eq=False)
class ActingTerm:
    """A term of an equation whose strength may vary, and what it was in a record.

    Attributes
    ----------
    part : Sum
        The term, without its coefficient.
    values : ndarray of shape (n_samples,)
        Its values.
    branch : int
        Tells it from the other terms of its equation.
    """

    part: Sum
    values: np.ndarray
    branch: int = 0


def pumping(
    residual: np.ndarray, values: np.ndarray, n_periods: int, highest: float = np.inf
) -> list[float]:
    """Return the frequency at which a wave of the time, times a signal, explains most.

    Parameters
    ----------
    residual, values : ndarray of shape (n,)
        Uniformly sampled. A multiple of the values is fitted as well, to see only what varies.
    n_periods : int
        Periods in the residual, at least.
    highest : float
        Frequency up to which to look, cycles a sample.

    Returns
    -------
    list of float
        One, cycles a sample; none where no wave explains a notable share.
    """
    if not np.isfinite(residual * values).all():
        return []
    square = float(np.sum(residual**2))
    return _strongest(residual * values, values**2, square, n_periods, highest)


def rippling(
    residual: np.ndarray,
    values: np.ndarray,
    place: np.ndarray,
    n_bins: int,
    n_periods: int,
    highest: float = np.inf,
) -> list[float]:
    """Return the wave number at which a wave of the position, times a signal, explains most.

    Parameters
    ----------
    residual, values, place : ndarray of shape (n,)
        Residual and signal, and the position at each sample.
    n_bins : int
        Pieces of the stroke, over each of which the wave is taken for constant.
    n_periods : int
        Periods within the stroke, at least.
    highest : float
        Wave number up to which to look, cycles per unit of the position.

    Returns
    -------
    list of float
        One, cycles per unit of the position; none where no wave explains a notable share.
    """
    if not np.isfinite(residual * values).all():
        return []
    (products, weights), edges, _ = binned_statistic(
        place, [residual * values, values**2], "sum", n_bins
    )
    width, square = float(edges[1] - edges[0]), float(np.sum(residual**2))
    found = _strongest(products, weights, square, n_periods, highest * width)
    return [cycles / width for cycles in found]


def _strongest(
    products: np.ndarray, weights: np.ndarray, square: float, n_periods: int, highest: float
) -> list[float]:
    """Return the frequency that explains most, cycles a sample, if that is a notable share."""
    n_fine = ROUGHNESS * fft.next_fast_len(len(products), real=True)
    places = np.arange(n_fine // 4 + 1)
    moved = fft.rfft(products, n_fine)
    weight = fft.rfft(weights, n_fine)
    total = max(float(weight[0].real), TINY)
    once, twice = weight[places] / total, weight[2 * places] / total
    b = moved[places] - moved[0].real * once  # beside the multiple: cosine - i sine
    cosines = 0.5 * (1.0 + twice.real) - once.real**2
    sines = 0.5 * (1.0 - twice.real) - once.imag**2
    both = 0.5 * twice.imag - once.real * once.imag
    det = np.maximum(cosines * sines - both**2, SINGULAR)
    gain = b.real**2 * sines - 2.0 * b.real * b.imag * both + b.imag**2 * cosines
    shares = gain / (det * total * max(square, TINY))
    free = (places > ROUGHNESS * n_periods) & (places < highest * n_fine)
    peak = int(np.argmax(np.where(free, shares, 0.0)))
    return [vertex(shares, peak) / n_fine] if free[peak] and shares[peak] > PUMPED else []
