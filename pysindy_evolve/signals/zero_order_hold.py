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

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from functools import partial

import numpy as np
from scipy.interpolate import CubicSpline, make_interp_spline

from .acting import InputFunction
from .record import Record
from .spectral import Array

__all__ = ["HALF", "acting_through", "acts_as", "averaged", "changed", "hold", "rates_of"]

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
            acting[:, column] = changed(record, column, partial(response, late=share), u[:, column])
        return acting

    return replace(_with_steps(record, new).with_inputs(as_acting), held={**record.held, **new})


def acting_through(record: Record, functions: Mapping[int, InputFunction]) -> Record:
    """Return a record with inputs whose functions are what acts, after hold and low-pass.

    Parameters
    ----------
    record : Record
        Inputs that act as they are.
    functions : mapping of int to InputFunction
        Through which function each of some inputs acts.

    Returns
    -------
    Record
        The same one if there are no functions, or no raw inputs.
    """
    made = record.preparation
    if not functions or made is None or made.u is None:
        return record
    recorded = record.recorded_u
    covering = {k: one.covering(recorded[:, k]) for k, one in functions.items()}
    functions = {k: one for k, one in covering.items() if one.is_invertible}
    late = {column: share for column, share in record.held.items() if column in functions}
    known = {column: share for column, share in record.held.items() if column not in late}

    def as_recorded(_: Array, u: Array) -> Array:
        plain = u.copy()
        plain[:, list(late)] = recorded[:, list(late)]
        return plain

    through = replace(record, through=functions, held=known)
    return hold(through.with_inputs(as_recorded), late)


def changed(record: Record, column: int, change: Callable[[Array], Array], u: Array) -> Array:
    """Return an input after a linear operation on what acts of it.

    Parameters
    ----------
    record : Record
        Says through which function the input acts, if any.
    column : int
        Which input it is.
    change : callable
        The operation, from (n_samples,) to (n_samples,).
    u : ndarray of shape (n_samples,)
        The input.

    Returns
    -------
    ndarray of shape (n_samples,)
    """
    function = record.through.get(column)
    return change(u) if function is None else function.after(change, u, change(u))


def acts_as(record: Record, column: int, u: Array) -> Array:
    """Return what acts of an input, (n_samples,): itself, or a function of it."""
    function = record.through.get(column)
    return u if function is None else np.asarray(function.function(u))


def _with_steps(record: Record, columns: Iterable[int]) -> Record:
    """Return a record that keeps what was recorded of inputs that will be given as what acts."""
    made = record.preparation
    if made is None or made.u is None:
        return record
    steps = np.array(made.u if made.steps is None else made.steps)
    steps[:, list(columns)] = made.u[:, list(columns)]
    return replace(record, preparation=replace(made, steps=steps))


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
