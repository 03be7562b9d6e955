"""Inputs that are held from each sample to the next (zero-order hold), as a controller does.

What is recorded at a sample begins there and ends at the next one. Between the samples a record is
taken to run smoothly, so such an input acts half a sample later than it seems to; and one that may
jump at any time between two samples is late by its own share of one. Below half the sampling rate
it acts as its mean over a sampling time does.

The steps have a part above half the sampling rate too, which the samples of a state that the input
drives directly show as if it were slow (aliasing). There the input is taken for what the samples of
its integral show, which is exact for an integrator. Of a second integral next to nothing is left.

References
----------
Astrom and Wittenmark, Computer-Controlled Systems, 3rd ed. (1997), chapters 2 and 7.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from scipy.interpolate import CubicSpline, make_interp_spline

from .record import Record
from .spectral import Array

__all__ = ["HALF", "averaged", "hold", "rates_of"]

HALF = 0.5  # sampling times by which a held input is late
AROUND = 8  # samples before and after a record, on which an input stands as at its ends
DEGREE = 5  # of splines


def hold(record: Record, late: Mapping[int, float]) -> Record:
    """Return a record whose inputs are held, given as what acts; those known as held stay.

    Parameters
    ----------
    record : Record
        Inputs as the values that begin at the samples.
    late : mapping of int to float
        Which inputs are held, and by how much each is late, in sampling times.

    Returns
    -------
    Record
        The same motion.
    """
    new = {column: share for column, share in late.items() if column not in record.held}
    if record.u is None or not new:
        return record
    made = record.preparation
    response = _later if made is None else _integrated if made.order == 1 else averaged

    def as_acting(_: Array, u: Array) -> Array:
        acting = u.copy()
        for column, share in new.items():
            acting[:, column] = response(u[:, column], share)
        return acting

    return replace(record.with_inputs(as_acting), held={**record.held, **new})


def averaged(u: Array, late: float) -> Array:
    """Return the mean of an input over the sampling time about a time before each sample.

    Parameters
    ----------
    u : ndarray of shape (n_samples,)
        Taken to run smoothly, and to rest before and after.
    late : float
        By how much, in sampling times.

    Returns
    -------
    ndarray of shape (n_samples,)
    """
    padded = _padded(u)
    total = make_interp_spline(np.arange(padded.size), padded, DEGREE).antiderivative()
    times = AROUND + np.arange(u.size) - late
    return np.asarray(total(times + HALF) - total(times - HALF))


def rates_of(u: Array, order: int) -> Array:
    """Return derivatives of smooth columns, (n_samples,) or (n_samples, n_columns).

    Per sampling time, or per its square where the order is 2.
    """
    samples = np.arange(len(u))
    return np.asarray(make_interp_spline(samples, u, DEGREE).derivative(order)(samples))


def _later(u: Array, late: float) -> Array:
    """Return an input, (n_samples,), some sampling times later, at rest before it was recorded."""
    samples = np.arange(u.size, dtype=float)
    return np.asarray(CubicSpline(samples, u)(np.maximum(samples - late, 0.0)))


def _integrated(u: Array, late: float) -> Array:
    """Return the derivative of what samples show of the integral of the steps of an input."""
    padded = _padded(u)
    samples = np.arange(padded.size, dtype=float)
    total = np.concatenate([[0.0], np.cumsum(padded[:-1])])
    shown = np.interp(samples - (late - HALF), samples, total)
    return rates_of(shown, 1)[AROUND:-AROUND]


def _padded(u: Array) -> Array:
    return np.pad(u, AROUND, mode="edge")
