"""Predict a record in windows, each from its measured state: the cheap simulation error."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..equations import Equations
from .columns import Columns, Field, choose_substeps, field_of
from .crossing import advance, start_signs
from .inputs import as_equations, check_input, check_states, check_time

__all__ = ["simulate_windows"]

TOLERANCE = 1e-6  # of a sample interval, relative to the state
MAX_SUBSTEPS = 20


def simulate_windows(
    model: Any,
    x: Any,
    t: Any,
    u: Any = None,
    *,
    window: int = 100,
    stride: int | None = None,
    substeps: int | None = None,
    coef: Any = None,
) -> tuple[np.ndarray, np.ndarray]:
    """Integrate a model over many windows of a record at once, each from its measured state.

    Parameters
    ----------
    model : SINDy, Equations, or an object whose `equations` are Equations
        A model in continuous time.
    x : array-like of shape (n_samples, n_states)
        Measured states.
    t : array-like of shape (n_samples,)
        Times, strictly increasing.
    u : array-like of shape (n_samples,) or (n_samples, n_inputs), optional
        Inputs at t, linear in between.
    window : int
        Samples that are predicted in each window.
    stride : int, optional
        Samples between the starts of two windows; by default `window`, so that each sample but
        the starts and a remainder at the end is predicted once.
    substeps : int, optional
        Runge-Kutta steps a sample interval; by default from the error of one step.
    coef : array-like of shape (n_models, n_states, n_terms), optional
        Coefficients of several models with the terms of this one.

    Returns
    -------
    predicted : ndarray of shape (n_windows, window, n_states)
        States at the samples `index`; with `coef` of shape (n_models, n_windows, window,
        n_states). Where a model diverges, values are not finite.
    index : ndarray of shape (n_windows, window)
        Samples that are predicted.

    Raises
    ------
    ValueError
        If a shape is wrong, t does not increase, or the record is shorter than a window.

    Notes
    -----
    A step is cut where a sign switches, as in `simulate`, but located in two refinements, and a
    switch that sticks is released at the end of the step in which it should be. The cost grows
    with `window` and hardly with the number of windows.
    """
    owner = "simulate_windows"
    equations = as_equations(model, owner)
    times = check_time(t, owner)
    states = check_states(x, times, equations, owner)
    inputs = check_input(u, times, equations, owner)
    batch = _check_coef(coef, equations)
    starts = _starts(len(times), window, stride)
    field, n_models = field_of(equations, batch), len(batch)
    columns = _columns(field, states, inputs, times, starts, n_models)
    steps = np.diff(times)
    slopes = np.diff(inputs, axis=0) / steps[:, None]
    out = np.empty((window, len(equations.states), n_models * len(starts)))
    with np.errstate(all="ignore"):
        h = np.tile(steps[starts], n_models)
        columns = _fed(columns, inputs, slopes, times, starts, n_models)
        columns = start_signs(field, columns, h)
        n = substeps or choose_substeps(field, columns, h, TOLERANCE, MAX_SUBSTEPS)
        for j in range(window):
            columns = _fed(columns, inputs, slopes, times, starts + j, n_models)
            h = np.tile(steps[starts + j], n_models) / n
            for _ in range(n):
                columns = advance(field, columns, h)
            out[j] = columns.x
    predicted = out.reshape(window, len(equations.states), n_models, len(starts))
    predicted = predicted.transpose(2, 3, 0, 1)
    index = starts[:, None] + np.arange(1, window + 1)
    return (predicted[0] if coef is None else predicted), index


def _columns(
    field: Field,
    x: np.ndarray,
    u: np.ndarray,
    t: np.ndarray,
    starts: np.ndarray,
    n_models: int,
) -> Columns:
    n_columns, n_switches = n_models * len(starts), len(field.switches)
    return Columns(
        x=np.tile(x[starts].T, n_models),
        u=np.tile(u[starts].T, n_models),
        du=np.zeros((u.shape[1], n_columns)),
        t=np.tile(t[starts], n_models),
        s=np.zeros((n_switches, n_columns)),
        held=np.zeros((n_switches, n_columns), dtype=bool),
        coef=field.coef_of(n_columns),
    )


def _fed(
    columns: Columns,
    u: np.ndarray,
    slopes: np.ndarray,
    t: np.ndarray,
    at: np.ndarray,
    n_models: int,
) -> Columns:
    """Put the measured inputs of the next sample interval into the columns."""
    u, slopes, t = (np.tile(part[at].T, n_models) for part in (u, slopes, t))
    return columns.fed(u, slopes, t)


def _starts(n_samples: int, window: int, stride: int | None) -> np.ndarray:
    for name, value in (("window", window), ("stride", stride)):
        if name == "stride" and value is None:
            continue
        if not isinstance(value, int | np.integer) or value < 1:
            raise ValueError(
                f"simulate_windows({name}=...) must be an integer of at least 1; got {value!r}. "
                "Give a number of samples."
            )
    if n_samples <= window:
        raise ValueError(
            f"simulate_windows(window=...) must be below the {n_samples} samples of the record; "
            f"got {window}. Take a shorter window."
        )
    return np.arange(0, n_samples - window, stride or window)


def _check_coef(coef: Any, equations: Equations) -> np.ndarray:
    if coef is None:
        return np.asarray(equations.coef, dtype=float)[None]
    batch = np.asarray(coef, dtype=float)
    shape = (len(equations.states), len(equations.terms))
    if batch.ndim != 3 or batch.shape[1:] != shape:
        raise ValueError(
            f"simulate_windows(coef=...) must have shape (n_models, {shape[0]}, {shape[1]}); "
            f"got {batch.shape}. Stack the coefficients of the models along the first axis."
        )
    return batch
