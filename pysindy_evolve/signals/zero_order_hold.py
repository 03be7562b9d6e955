"""Inputs that are held from each sample to the next (zero-order hold), as by a controller.

The value recorded at a sample acts until the next one. A record is otherwise taken to be smooth
between samples, so a held input acts half a sampling time later than it seems to. An input that
jumps at another time between samples is late by another share of it. Below half the sampling rate a
held input acts as its mean over a sampling time.

The steps also have components above half the sampling rate. In the samples of a state that the
input drives directly they appear at low frequencies (aliasing). For such a state the effective
input is the slope of the sampled integral of the steps, which is exact for an integrator. A second
integral removes nearly all of this aliasing.

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

HALF_SAMPLE = 0.5  # sampling times by which a held input is late
N_MARGIN_SAMPLES = 8  # samples added before and after a record, with the input constant there
DEGREE = 5  # of the splines


def hold(record: Record, late: Mapping[int, float]) -> Record:
    """Return a record in which held inputs are replaced by their effective, delayed values.

    Parameters
    ----------
    record : Record
        Holds the values of the inputs that begin at the samples.
    late : mapping of int to float
        Held inputs: column to delay, in sampling times. Inputs that the record already knows as
        held are left as they are.

    Returns
    -------
    Record
        With the same states.
    """
    new = {column: share for column, share in late.items() if column not in record.held}
    if record.u is None or not new:
        return record
    made = record.preparation
    response = _later if made is None else _integrated if made.order == 1 else averaged

    def as_acting(_: Array, u: Array) -> Array:
        acting = u.copy()
        for column, share in new.items():
            acting[:, column] = apply_to_effective_input(
                record, column, partial(response, late=share), u[:, column]
            )
        return acting

    return replace(_with_steps(record, new).with_inputs(as_acting), held={**record.held, **new})


def acting_through(record: Record, functions: Mapping[int, InputFunction]) -> Record:
    """Return a record in which hold and low-pass are applied to functions of its inputs.

    Parameters
    ----------
    record : Record
        With hold and low-pass applied to the inputs themselves.
    functions : mapping of int to InputFunction
        Function through which an input acts, by its column. Those without an inverse are ignored.

    Returns
    -------
    Record
        The same object if there are no functions, or no raw inputs.
    """
    made = record.preparation
    if not functions or made is None or made.u is None:
        return record
    recorded = record.recorded_u
    covering = {k: function.covering(recorded[:, k]) for k, function in functions.items()}
    functions = {k: function for k, function in covering.items() if function.is_invertible}
    delayed = {column: share for column, share in record.held.items() if column in functions}
    others = {column: share for column, share in record.held.items() if column not in delayed}

    def as_recorded(_: Array, u: Array) -> Array:
        as_recorded_u = u.copy()
        as_recorded_u[:, list(delayed)] = recorded[:, list(delayed)]
        return as_recorded_u

    record_through = replace(record, through=functions, held=others)
    return hold(record_through.with_inputs(as_recorded), delayed)


def apply_to_effective_input(
    record: Record, column: int, change: Callable[[Array], Array], u: Array
) -> Array:
    """Apply a linear operation to an input, or to the function through which it acts.

    Parameters
    ----------
    record : Record
        Holds the function through which the input acts, if any.
    column : int
        Column of the input.
    change : callable
        The operation, from (n_samples,) to (n_samples,).
    u : ndarray of shape (n_samples,)
        The input.

    Returns
    -------
    ndarray of shape (n_samples,)
        The changed input, units of u.
    """
    function = record.through.get(column)
    return change(u) if function is None else function.after(change, u, change(u))


def acts_as(record: Record, column: int, u: Array) -> Array:
    """Return an input, (n_samples,), or the function of it through which it acts."""
    function = record.through.get(column)
    return u if function is None else np.asarray(function.function(u))


def _with_steps(record: Record, columns: Iterable[int]) -> Record:
    """Return a record whose preparation keeps the recorded values of some inputs as `steps`."""
    made = record.preparation
    if made is None or made.u is None:
        return record
    steps = np.array(made.u if made.steps is None else made.steps)
    steps[:, list(columns)] = made.u[:, list(columns)]
    return replace(record, preparation=replace(made, steps=steps))


def averaged(u: Array, late: float) -> Array:
    """Return the mean of an input over one sampling time, centered shortly before each sample.

    Parameters
    ----------
    u : ndarray of shape (n_samples,)
        The input, taken as smooth, and as constant before and after.
    late : float
        How long before, in sampling times.

    Returns
    -------
    ndarray of shape (n_samples,)
    """
    padded = _padded(u)
    integral = make_interp_spline(np.arange(padded.size), padded, DEGREE).antiderivative()
    times = N_MARGIN_SAMPLES + np.arange(u.size) - late
    return np.asarray(integral(times + HALF_SAMPLE) - integral(times - HALF_SAMPLE))


def rates_of(u: Array, order: int) -> Array:
    """Return derivatives of smooth columns, (n_samples,) or (n_samples, n_columns).

    Units of u per sampling time to the power of order.
    """
    samples = np.arange(len(u))
    return np.asarray(make_interp_spline(samples, u, DEGREE).derivative(order)(samples))


def _later(u: Array, late: float) -> Array:
    """Return an input, (n_samples,), delayed; it is constant before its first sample."""
    samples = np.arange(u.size, dtype=float)
    return np.asarray(CubicSpline(samples, u)(np.maximum(samples - late, 0.0)))


def _integrated(u: Array, late: float) -> Array:
    """Return the derivative of a spline through the sampled integral of a held input."""
    padded = _padded(u)
    samples = np.arange(padded.size, dtype=float)
    integral = np.concatenate([[0.0], np.cumsum(padded[:-1])])
    samples_of_integral = np.interp(samples - (late - HALF_SAMPLE), samples, integral)
    return rates_of(samples_of_integral, 1)[N_MARGIN_SAMPLES:-N_MARGIN_SAMPLES]


def _padded(u: Array) -> Array:
    return np.pad(u, N_MARGIN_SAMPLES, mode="edge")
