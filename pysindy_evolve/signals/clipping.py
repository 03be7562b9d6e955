"""Readings at an end of a sensor's range: found, and bridged before a filter spreads their kinks.

Behind such readings the true value goes on where nobody sees it. A low-pass would carry the kinks
at both ends of each gap far into the rows around it, and the second derivative of a kink is an
impulse. So the gaps are bridged by the smoothest curve that meets the readings around them and
stays beyond the limit. It is no measurement: the rows of a gap still say nothing.

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

__all__ = ["as_limits", "beyond", "bridged", "longest", "sensor_limits", "widened"]

LEAST_IN_A_ROW = 3  # readings at a limit, or where a machine rests
LEAST_READINGS = 2  # at a limit, beyond what a crest of a rounded signal holds ...
CREST = 5  # ... which holds at most so many times the readings of the levels next to it
NEXT_LEVELS = 3
AS_LONG = 0.25  # times the longest stay at a limit: a machine stops for longer here than there
MOST = 0.5  # share of the readings; readings that stay at an extreme more often are no limit
# Of the time before a gap, so much in lengths of a gap is looked at: a crest of a sine then covers
# 0.7 of the way of the time before, what comes to rest a third.
SHARE_OF_GAP = 0.25
SLOWED = 0.5
FEWEST = 3  # arrivals, from which on their scatter says whether a machine slows down
CHANCE = 2.0  # standard errors
ORDER = 3  # of the differences that the bridge keeps small: curvatures at both ends meet
HOLD = 1e-12  # pull of the limit in a gap, relative to smoothness: well above the rounding
FREQUENCIES = (4e-3, 0.5)  # cycles per sample; below, rounding is more than the readings weigh
SHARPNESS = 2.0  # cutoffs, beyond which the bridge follows the noise of the readings no more
REACH = 1.0  # periods of the cutoff beside a gap in which the filter still feels the bridge


def sensor_limits(y: Array) -> Array:
    """Return the lowest and the highest reading that sensors can show, as far as they show it.

    A limit is an extreme that stays for several readings in a row, and is read far more often than
    the levels next to it: a smooth signal, however rounded, has no such heap at its crests. The
    readings meet it at full speed, where a machine that comes to rest slows down. A coarse sensor
    repeats its readings at every rest, and shows none; nor does one whose readings stay elsewhere
    for a time that compares, as those of a machine that moves from stop to stop.

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
        if _is_heap(readings, top) and not _is_coarse(readings) and not _stops(readings, top):
            limits[int(upper), column] = top if upper else -top
    return limits


def _is_heap(readings: Array, top: float) -> bool:
    """Tell whether readings heap at their highest value, in gaps with others on both sides."""
    inside = np.flatnonzero(readings != top)
    if len(inside) < (1.0 - MOST) * len(readings):
        return False
    readings = readings[inside[0] : inside[-1] + 1]  # a machine may rest before it starts
    there = readings == top
    if longest(there) < LEAST_IN_A_ROW:
        return False
    counts = np.unique(readings, return_counts=True)[1]
    beside = counts[-1 - NEXT_LEVELS : -1].max(initial=0)
    return bool(counts[-1] >= LEAST_READINGS + CREST * beside) and _arrives(readings, there, top)


def _arrives(readings: Array, there: NDArray[np.bool_], top: float) -> bool:
    """Tell whether readings meet their end at full speed, and do not come to rest there.

    What comes to rest covers less than half of the way in the last of two equal times.
    """
    starts, ends = _runs(there)
    long = ends - starts >= LEAST_IN_A_ROW
    starts, typical = starts[long], float(np.median((ends - starts)[long]))
    seen_since = np.concatenate([[0], np.cumsum(there)])
    span = 2
    while span <= max(2.0, SHARE_OF_GAP * typical):
        at = starts[starts >= 2 * span]
        at = at[seen_since[at] == seen_since[at - 2 * span]]  # no other gap on the way
        last = top - readings[at - span]
        before = readings[at - span] - readings[at - 2 * span]
        met = 1.0 - 0.5 / span  # between two samples
        faster = last - SLOWED * met * before
        if len(at) >= FEWEST and faster.mean() < -CHANCE * faster.std() / np.sqrt(len(at)):
            return False
        span *= 2
    return True


def _stops(readings: Array, top: float) -> bool:
    """Tell whether readings stay elsewhere for a time that compares with that at the highest."""
    ends = np.flatnonzero(np.diff(readings)) + 1  # without its rests before and after all motion
    stays, values = np.diff(ends), readings[ends[:-1]]
    between = (values < top) & (values > readings.min()) & (stays >= LEAST_IN_A_ROW)
    return bool(stays[between].max(initial=0) >= AS_LONG * stays[values == top].max(initial=0))


def _is_coarse(readings: Array) -> bool:
    """Tell whether readings repeat away from the extremes too: there they then rest, no more."""
    inside = readings[(readings != readings.max()) & (readings != readings.min())]
    return len(inside) < 2 or bool(np.mean(np.diff(inside) == 0.0) >= DWELL)


def longest(there: NDArray[np.bool_]) -> int:
    """Return the length of the longest run of True."""
    starts, ends = _runs(there)
    return int(np.max(ends - starts, initial=0))


def _runs(there: NDArray[np.bool_]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return first sample and end of each run of True."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], there, [False]]).astype(int)))
    return edges[::2], edges[1::2]


def as_limits(limits: Any, y: Array) -> Array:
    """Return limits as (2, n_columns), from "auto", None, or a lowest and a highest reading."""
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
    """Return readings with smooth curves in the place of those at a limit.

    Parameters
    ----------
    y : ndarray of shape (n, n_columns)
        Raw readings.
    limits : ndarray of shape (2, n_columns)
        Ends of the range of each sensor.
    dt : float
        Sampling time, units of t.
    cutoff : float or None
        Of the low-pass that follows, cycles per unit of t; by default the highest one.
    order : int
        States per column. One of the first order may stop at the limit itself, as a tank does that
        runs over; and its derivative has no more than steps there. So it has no bridge.

    Returns
    -------
    ndarray of shape (n, n_columns)
        The very same readings where none is at a limit. Gaps at an end of the record stay as they
        are: nothing holds a bridge there.
    """
    gone = beyond(y, limits)
    result = np.array(y)
    for column in np.flatnonzero(gone.any(axis=0)) if order > 1 else ():
        gap, readings, (low, high) = gone[:, column], y[:, column], limits[:, column]
        inside = np.flatnonzero(~gap)
        if len(inside) <= ORDER:
            continue
        span = np.ptp(readings)  # nobody believes a bridge that goes further
        frequency = np.clip(SHARPNESS * (cutoff or np.inf) * dt, *FREQUENCIES)
        curve = _smooth(readings, ~gap, float(frequency))
        curve = np.where(
            readings >= high,
            np.clip(curve, high, high + span),
            np.clip(curve, low - span, low),
        )
        held = gap.copy()
        held[: inside[0]] = held[inside[-1] + 1 :] = False
        result[held, column] = curve[held]
    return result


def _smooth(readings: Array, seen: NDArray[np.bool_], frequency: float) -> Array:
    """Return the smoothest curve near the readings that are seen.

    Its gain is one half at a frequency, in cycles per sample. Across very long gaps, over which
    curvatures say nothing, it comes back to the limit.
    """
    n = len(readings)
    difference = np.array([(-1) ** k * comb(ORDER, k) for k in range(ORDER + 1)], dtype=float)
    bands = np.zeros((ORDER + 1, n))
    for lag in range(ORDER + 1):
        for k in range(ORDER + 1 - lag):
            place = slice(k + lag, n - ORDER + k + lag)
            bands[ORDER - lag, place] += difference[k] * difference[k + lag]
    bands /= (2.0 * np.sin(np.pi * frequency)) ** (2 * ORDER)
    weight = np.where(seen, 1.0, HOLD * bands[-1].max())
    bands[-1] += weight
    return np.asarray(solveh_banded(bands, weight * readings))


def widened(gone: NDArray[np.bool_], dt: float, cutoff: float | None) -> NDArray[np.bool_]:
    """Return gaps (n, n_columns) with the samples beside them that a low-pass spoils."""
    reach = ORDER if cutoff is None else int(np.ceil(REACH / (cutoff * dt)))
    count = np.cumsum(np.vstack([np.zeros((1, gone.shape[1]), dtype=int), gone]), axis=0)
    index = np.arange(len(gone))
    last = np.minimum(index + reach + 1, len(gone))
    return np.asarray(count[last] > count[np.maximum(index - reach, 0)])
