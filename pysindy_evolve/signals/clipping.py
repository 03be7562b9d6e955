"""Readings at an end of a sensor's range (clipping): found, and bridged before they are filtered.

While a sensor clips, the true value goes on beyond the limit. A low-pass would spread the kinks at
both ends of such a gap over the rows around it, and the second derivative of a kink is an impulse.
So each gap is bridged by the smoothest curve that meets the readings around it and stays beyond the
limit. The bridge is no measurement: the rows of a gap do not count as seen.

References
----------
Eilers, A perfect smoother, Anal. Chem. 75 (2003), DOI 10.1021/ac034173t: gaps have weight zero.
"""

from __future__ import annotations

from itertools import product
from math import comb
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solveh_banded

from .. import checks
from .noise import DWELL
from .spectral import Array

LEAST_STAY = 3  # consecutive readings that count as a stay: at a limit, or where a machine rests
# A crest of a rounded signal holds at most CREST_RATIO times as many readings as a level next to
# it; a limit needs LEAST_EXTRA more. NEXT_LEVELS levels below the limit are compared.
LEAST_EXTRA = 2
CREST_RATIO = 5
NEXT_LEVELS = 3
OTHER_STAY = 0.25  # of the longest stay at the extreme; a longer stay elsewhere is a machine's stop
MOST_AT_LIMIT = 0.5  # share of the readings; an extreme that holds more of them is no limit
# Before a stay, two equal spans are compared, of up to a quarter of its length. In the second one
# the crest of a sine covers 0.7 of the way of the first, and what comes to rest a third. Less than
# SLOWED means a rest.
SPAN_OF_STAY = 0.25
SLOWED = 0.5
FEWEST_HITS = 3  # arrivals at the limit that are needed to judge their scatter
# Standard errors by which the way must be shorter to count as coming to rest.
MIN_STANDARD_ERRORS = 2.0
ORDER = 3  # order of the differences that the bridge keeps small: its curvature is continuous
LIMIT_WEIGHT = 1e-12  # weight of the limit in a gap, relative to smoothness; well above rounding
FREQUENCY_RANGE = (4e-3, 0.5)  # cycles per sample; below it, rounding outweighs the readings
SHARPNESS = 2.0  # cutoffs; the bridge does not follow the readings at higher frequencies
SPOILED_PERIODS = 1.0  # periods of the cutoff; rows nearer to a gap are spoiled by the filter


def sensor_limits(y: Array) -> Array:
    """Find the lowest and the highest reading that sensors can show.

    A limit is an extreme that stays for several readings in a row, and is read far more often than
    the levels next to it: a smooth signal, however rounded, has no such heap at its crests. The
    readings reach it at full speed, while a machine that comes to rest slows down. No limit is
    found for a coarse sensor, which repeats its readings at every rest, nor where the readings stay
    elsewhere for a comparable time, as those of a machine that moves from stop to stop.

    Parameters
    ----------
    y : ndarray of shape (n, n_columns)
        Raw readings.

    Returns
    -------
    ndarray of shape (2, n_columns)
        Infinite where no limit shows.
    """
    limits = np.array([[-np.inf], [np.inf]]) * np.ones(y.shape[1])
    for column, upper in product(range(y.shape[1]), (False, True)):
        readings = y[:, column] if upper else -y[:, column]
        top = readings.max()
        if (
            _heaps_at_top(readings, top)
            and not _is_coarse(readings)
            and not _stays_elsewhere(readings, top)
        ):
            limits[int(upper), column] = top if upper else -top
    return limits


def _heaps_at_top(readings: Array, top: float) -> bool:
    """Tell whether readings heap at their highest value, at stays with others on both sides."""
    below = np.flatnonzero(readings != top)
    if len(below) < (1.0 - MOST_AT_LIMIT) * len(readings):
        return False
    readings = readings[below[0] : below[-1] + 1]  # a machine may rest before it starts
    at_top = readings == top
    if longest(at_top) < LEAST_STAY:
        return False
    counts = np.unique(readings, return_counts=True)[1]
    beside = counts[-1 - NEXT_LEVELS : -1].max(initial=0)
    return bool(counts[-1] >= LEAST_EXTRA + CREST_RATIO * beside) and _arrives_fast(
        readings, at_top, top
    )


def _arrives_fast(readings: Array, at_top: NDArray[np.bool_], top: float) -> bool:
    """Tell whether readings reach their highest value at full speed, and do not come to rest there.

    A machine that comes to rest covers less than half as far in the second of two equal spans.
    """
    starts, ends = _runs(at_top)
    is_stay = ends - starts >= LEAST_STAY
    starts, typical = starts[is_stay], float(np.median((ends - starts)[is_stay]))
    n_at_top = np.concatenate([[0], np.cumsum(at_top)])
    span = 2
    while span <= max(2.0, SPAN_OF_STAY * typical):
        hits = starts[starts >= 2 * span]
        hits = hits[n_at_top[hits] == n_at_top[hits - 2 * span]]  # not at the limit in the spans
        last = top - readings[hits - span]
        before = readings[hits - span] - readings[hits - 2 * span]
        partial = 1.0 - 0.5 / span  # the limit is met between two samples
        excess = last - SLOWED * partial * before
        n = len(hits)
        if n >= FEWEST_HITS and excess.mean() < -MIN_STANDARD_ERRORS * excess.std() / np.sqrt(n):
            return False
        span *= 2
    return True


def _stays_elsewhere(readings: Array, top: float) -> bool:
    """Tell whether readings stay at a value in between for a time comparable with the highest."""
    changes = np.flatnonzero(np.diff(readings)) + 1  # of the rows between the first and last motion
    stays, values = np.diff(changes), readings[changes[:-1]]
    elsewhere = (values < top) & (values > readings.min()) & (stays >= LEAST_STAY)
    return bool(stays[elsewhere].max(initial=0) >= OTHER_STAY * stays[values == top].max(initial=0))


def _is_coarse(readings: Array) -> bool:
    """Tell whether readings repeat away from the extremes too: then a stay there is a mere rest."""
    inside = readings[(readings != readings.max()) & (readings != readings.min())]
    return len(inside) < 2 or bool(np.mean(np.diff(inside) == 0.0) >= DWELL)


def longest(flags: NDArray[np.bool_]) -> int:
    """Return the length of the longest run of True, in samples."""
    starts, ends = _runs(flags)
    return int(np.max(ends - starts, initial=0))


def _runs(flags: NDArray[np.bool_]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return first sample and end of each run of True."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(int)))
    return edges[::2], edges[1::2]


def as_limits(limits: Any, y: Array) -> Array:
    """Return limits, shape (2, n_columns), from "auto", None, or a lowest and a highest reading."""
    if limits is None:
        return np.array([[-np.inf], [np.inf]]) * np.ones(y.shape[1])
    if isinstance(limits, str) and limits == "auto":
        return sensor_limits(y)
    advice = 'Write "auto" to take them from readings that stay at an extreme.'
    must = '"auto", None or the lowest and the highest reading'
    try:
        low, high = (np.broadcast_to(np.asarray(end, dtype=float), y.shape[1]) for end in limits)
    except (TypeError, ValueError):
        checks.refuse("prepare", "limits", must, repr(limits), advice)
    if not np.all(low < high):
        checks.refuse("prepare", "limits", "increasing", repr(limits), advice)
    return np.stack([low, high])


def beyond(y: Array, limits: Array) -> NDArray[np.bool_]:
    """Tell which readings (n, n_columns) are at a limit, so that the true value may be beyond."""
    return np.asarray((y <= limits[0]) | (y >= limits[1]))


def bridged(y: Array, limits: Array, dt: float, cutoff: float | None, order: int = 2) -> Array:
    """Return readings with those at a limit replaced by smooth curves.

    Parameters
    ----------
    y : ndarray of shape (n, n_columns)
        Raw readings.
    limits : ndarray of shape (2, n_columns)
        Ends of the range of each sensor.
    dt : float
        Sampling time, units of t.
    cutoff : float or None
        Cutoff of the low-pass that follows, cycles per unit of t; None if there is none.
    order : int
        States per column. A column of order 1 is not bridged: its state may stop at the limit
        itself, as the level of a tank that overflows, and its derivative only steps there.

    Returns
    -------
    ndarray of shape (n, n_columns)
        Readings that are not at a limit are unchanged, as are gaps at an end of the record, which
        have readings on one side only.
    """
    at_limit = beyond(y, limits)
    result = np.array(y)
    for column in np.flatnonzero(at_limit.any(axis=0)) if order > 1 else ():
        gap, readings, (low, high) = at_limit[:, column], y[:, column], limits[:, column]
        seen = np.flatnonzero(~gap)
        if len(seen) <= ORDER:
            continue
        span = np.ptp(readings)  # a bridge further beyond the limit is not credible
        frequency = np.clip(SHARPNESS * (cutoff or np.inf) * dt, *FREQUENCY_RANGE)
        curve = _smooth(readings, ~gap, float(frequency))
        curve = np.where(
            readings >= high, np.clip(curve, high, high + span), np.clip(curve, low - span, low)
        )
        bridge = gap.copy()
        bridge[: seen[0]] = bridge[seen[-1] + 1 :] = False
        result[bridge, column] = curve[bridge]
    return result


def _smooth(readings: Array, seen: NDArray[np.bool_], frequency: float) -> Array:
    """Return a smooth curve through the readings that are seen, and across the gaps.

    Its gain is one half at the frequency, in cycles per sample. Across very long gaps, which the
    curvature at their ends does not determine, it returns to the limit.
    """
    n = len(readings)
    coefficients = np.array([(-1) ** k * comb(ORDER, k) for k in range(ORDER + 1)], dtype=float)
    matrix = np.zeros((ORDER + 1, n))
    for lag in range(ORDER + 1):
        for k in range(ORDER + 1 - lag):
            diagonal = slice(k + lag, n - ORDER + k + lag)
            matrix[ORDER - lag, diagonal] += coefficients[k] * coefficients[k + lag]
    matrix /= (2.0 * np.sin(np.pi * frequency)) ** (2 * ORDER)
    weight = np.where(seen, 1.0, LIMIT_WEIGHT * matrix[-1].max())
    matrix[-1] += weight
    return np.asarray(solveh_banded(matrix, weight * readings))


def widened(gone: NDArray[np.bool_], dt: float, cutoff: float | None) -> NDArray[np.bool_]:
    """Return gaps (n, n_columns), widened by the samples beside them that a low-pass spoils."""
    reach = ORDER if cutoff is None else int(np.ceil(SPOILED_PERIODS / (cutoff * dt)))
    count = np.cumsum(np.vstack([np.zeros((1, gone.shape[1]), dtype=int), gone]), axis=0)
    index = np.arange(len(gone))
    last = np.minimum(index + reach + 1, len(gone))
    return np.asarray(count[last] > count[np.maximum(index - reach, 0)])
