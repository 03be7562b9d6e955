"""Uniform sampling times, and resampling of records without them."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import CubicSpline

from .. import checks
from .spectral import Array

# Largest deviations of a time stamp from the uniform grid, as shares of the sampling time.
MAX_ROUNDING = 0.01  # time stamps are rounded: taken as uniform
MAX_JITTER = 0.5  # the clock jitters: the record is interpolated; beyond it, samples are missing


def mean_step(t: Array) -> float:
    """Return the mean sampling time of a record, units of t."""
    return float((t[-1] - t[0]) / (t.size - 1))


def uniform(call: str, t: Array, *columns: Array | None) -> tuple[Array, list[Array | None]]:
    """Return uniform times over the same span, and the columns at these times.

    Time stamps within 1 % of a sampling time of the uniform grid are taken as rounded. Within half
    a sampling time, every column is interpolated to the grid by a cubic spline.

    Raises
    ------
    ValueError
        If a time stamp is farther away.
    """
    grid = np.linspace(t[0], t[-1], t.size)
    deviation = np.abs(t - grid) / mean_step(t)
    worst = float(deviation.max())
    if worst > MAX_JITTER:
        steps = np.diff(t)
        usual = float(np.median(steps))
        index = int(np.argmax(np.abs(steps - usual)))
        got = f"a step of {steps[index]:g} at sample {index + 1} where {usual:g} is usual"
        advice = (
            "Resample it first: t, y, u = signals.resample(t, y, u). A gap of more than a few "
            "samples is better cut: give the two parts as two records, as resampling draws a "
            "straight line through it."
        )
        checks.refuse(call, "t", "uniform within half a sampling time", got, advice)
    if worst <= MAX_ROUNDING:
        return grid, list(columns)
    return grid, [None if c is None else np.asarray(CubicSpline(t, c)(grid)) for c in columns]


def resample(
    t: ArrayLike, y: ArrayLike, u: ArrayLike | None = None, dt: float | None = None
) -> tuple[Array, Array, Array | None]:
    """Interpolate an irregular record linearly to a uniform grid.

    Parameters
    ----------
    t : ndarray of shape (n_samples,)
        Time, strictly increasing.
    y : ndarray of shape (n_samples,) or (n_samples, n_columns)
        Measured signals.
    u : ndarray of shape (n_samples,) or (n_samples, n_inputs), optional
        Inputs.
    dt : float, optional
        New sampling time, units of t; the median step by default.

    Returns
    -------
    t : ndarray of shape (n_new,)
    y : ndarray of shape (n_new,) or (n_new, n_columns)
    u : ndarray of shape (n_new,) or (n_new, n_inputs), or None

    Raises
    ------
    ValueError
        If a value is not finite, lengths differ, time does not increase, or dt is not
        positive and shorter than the record.
    TypeError
        If an argument is not made of real numbers.

    Examples
    --------
    >>> t, y, _ = resample([0.0, 1.0, 3.0, 4.0], [0.0, 1.0, 3.0, 4.0])
    >>> y
    array([0., 1., 2., 3., 4.])
    """
    times = checks.times("resample", t)
    if times.size < 2:
        checks.refuse("resample", "t", "at least 2 samples long", f"{times.size}", "Record more.")
    signals = [checks.columns("resample", "y", y)]
    if u is not None:
        signals.append(checks.columns("resample", "u", u))
    checks.same_length("resample", t=times, y=signals[0], u=signals[-1])
    span = float(times[-1] - times[0])
    step = float(np.median(np.diff(times))) if dt is None else dt
    must_be = f"in [{span / 1e8:g}, {span:g}], shorter than the record"
    step = checks.number("resample", "dt", step, must_be, lambda v: span / 1e8 <= v <= span)
    grid = times[0] + step * np.arange(int(span / step * (1 + 1e-12)) + 1)
    new = [np.stack([np.interp(grid, times, c) for c in columns.T], axis=1) for columns in signals]
    new_y = [new[0][:, 0] if np.ndim(y) == 1 else new[0]]
    if u is None:
        return grid, new_y[0], None
    return grid, new_y[0], new[1][:, 0] if np.ndim(u) == 1 else new[1]
