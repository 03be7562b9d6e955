"""Tune the numbers of memories by free runs, the coefficients following each of them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from scipy.optimize import least_squares

from ..signals import Record
from .design import Design
from .drift import LONG, Drift, drift_of
from .fit import Fit
from .linear import solve_gram
from .trial import Trial, runs_of, settled
from .variants import Model

__all__ = ["fit_by_runs", "intervals_by_runs", "tuned"]

STEP = 0.02  # of the logarithm of a number, to see what it changes
REACH = 1.5  # of the logarithms about where they begin
MAX_LOOKS = 25
N_RESAMPLES = 400
LOST = 1e3  # what counts as the miss of a run that diverges


def tuned(drift: Drift, model: Model) -> Model:
    """Return a model with delays, time constants, brims and shares tuned; a share of zero stays.

    Parameters
    ----------
    drift : Drift
        Stretches of the record.
    model : Model
        With memories from a grid.

    Returns
    -------
    Model
    """
    start, at = _numbers(model)
    if not len(start):
        return model

    last = drift.trial

    def misses(places: list[np.ndarray]) -> list[np.ndarray]:
        nonlocal last
        begun = [replace(drift.begun(at(place)), starts=last.starts) for place in places]
        own = slice(len(last.coef))
        begun = [replace(one, coef=np.append(last.coef, one.coef[own.stop :])) for one in begun]
        trials = settled(begun)
        last = trials[0] if np.isfinite(trials[0].error) else last
        return [_miss(trial) for trial in trials]

    def slopes(logs: np.ndarray) -> np.ndarray:
        moved = misses([logs, *(logs + STEP * row for row in np.eye(len(logs)))])
        return np.column_stack([(one - moved[0]) / STEP for one in moved[1:]])

    found = least_squares(
        lambda logs: misses([logs])[0],
        start,
        jac=slopes,
        bounds=(start - REACH, start + REACH),
        max_nfev=MAX_LOOKS,
        ftol=1e-4,
        xtol=1e-4,
    )
    return at(found.x)


def fit_by_runs(
    design: Design, fitted: Fit, records: Sequence[Record], rng: np.random.Generator
) -> Fit:
    """Return coefficients that free runs over stretches give; the same fit where they cannot.

    Parameters
    ----------
    design : Design
        The model, limits included.
    fitted : Fit
        Where to begin.
    records : sequence of Record
        Training records, inputs as they act.
    rng : numpy.random.Generator
        Draws the stretches of the intervals.

    Returns
    -------
    Fit
    """
    long = drift_of(Model(design), fitted.coef, records, LONG)
    if long is None:
        return fitted
    intervals = intervals_by_runs(Model(design), long.trial.coef, records, rng)
    return Fit(long.trial.coef, intervals, "simulation")


def intervals_by_runs(
    model: Model, coef: np.ndarray, records: Sequence[Record], rng: np.random.Generator
) -> np.ndarray:
    """Return the 95 % intervals of the coefficients and then of the numbers of memories.

    Stretches are drawn with replacement, and what is free is fitted to them to first order; the
    scatter about the median is put about the values.

    Returns
    -------
    ndarray of shape (p + n_numbers, 2)
    """
    logs, at = _numbers(model)
    place = np.concatenate([coef, logs])
    drift = drift_of(model, coef, records)
    rows = None if drift is None else drift.trial.rows()
    if drift is None or rows is None:
        return np.full((len(place), 2), np.nan)
    trial = drift.trial
    begun = [drift.begun(at(logs + STEP * row)) for row in np.eye(len(logs))]
    moved = [rows.of((one.x - trial.x) / STEP) for one in runs_of([*begun, trial])[:-1]]
    miss = rows.of(trial.target - trial.x)
    every = rows.freed(np.concatenate([rows.response, *moved, miss], axis=2))
    grams = np.swapaxes(every, 1, 2) @ every
    draws = rng.integers(len(grams), size=(N_RESAMPLES, len(grams)))
    changes = np.array([solve_gram(grams[draw].sum(axis=0)) for draw in draws])
    low, high = np.quantile(changes, [0.025, 0.975], axis=0) - np.median(changes, axis=0)
    intervals = place[:, None] + np.column_stack([low, high])
    intervals[len(coef) :] = np.exp(intervals[len(coef) :])
    return intervals


def _numbers(model: Model) -> tuple[np.ndarray, Callable[[np.ndarray], Model]]:
    """Return the logarithms of the numbers of all memories, and the model with others."""
    flat = np.array([value for memory in model.memories for value in memory.values])
    n_known = sum(len(memory.values) for memory in model.memories[: model.n_known])
    free = n_known + np.flatnonzero(flat[n_known:])

    def at(logs: np.ndarray) -> Model:
        values = flat.copy()
        values[free] = np.exp(logs)
        memories, rest = [], list(values)
        for memory in model.memories:
            own, rest = rest[: len(memory.values)], rest[len(memory.values) :]
            memories.append(replace(memory, values=tuple(float(value) for value in own)))
        return replace(model, memories=tuple(memories))

    return np.log(flat[free]), at


def _miss(trial: Trial) -> np.ndarray:
    miss = ((trial.target - trial.x) / trial.scale).ravel()
    return np.clip(np.nan_to_num(miss, nan=LOST, posinf=LOST, neginf=-LOST), -LOST, LOST)
