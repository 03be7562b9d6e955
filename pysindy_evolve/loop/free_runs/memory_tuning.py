"""Tune the numbers of memories by free runs, the coefficients following each of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...checks import TINY
from ...signals import Record
from ..fitting.fit import Fit
from ..fitting.linear import solve_gram
from ..fitting.trial import Trial, converged, runs_of
from ..given.design import Design
from .drift import LONG, Drift, drift_of
from .variants import Model, Pasts

__all__ = ["fit_by_runs", "intervals_by_runs", "tuned_memories"]

STEP = 0.02  # of the logarithm of a number, to see what it changes
REACH = 1.5  # of the logarithms about where they begin
MAX_STEPS = 50
SETTLED = 1e-4  # relative gain of a step after which no other one is taken
DAMPINGS = (1e-6, 1e-4, 1e-3, 1e-2, 0.1, 1.0, 10.0)  # of steps, relative to the squares of columns
N_RESAMPLES = 400


def tuned_memories(drift: Drift, model: Model) -> Model:
    """Return a model with delays, time constants, brims and shares tuned; a share of zero stays.

    So is where the inputs stood before each record, which hidden states remember.

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
    numbers = _Numbers.of(model, drift.records)
    if not len(numbers.start):
        return model
    begun = drift.begun(numbers.at(numbers.start))
    (now,), place = converged([begun]), numbers.start
    for _ in range(MAX_STEPS):
        tried = _steps(drift, now, numbers, place) if np.isfinite(now.error) else []
        moved = runs_of([trial for trial, _ in tried])
        best = min(range(len(moved)), key=lambda k: moved[k].error, default=None)
        gain = 0.0 if best is None else 1.0 - moved[best].error / max(now.error, TINY)
        if best is not None and gain > 0.0:
            now, place = moved[best], tried[best][1]
        if gain < SETTLED:
            break
    return numbers.at(place)


def _steps(
    drift: Drift, trial: Trial, numbers: _Numbers, place: np.ndarray
) -> list[tuple[Trial, np.ndarray]]:
    """Return steps of coefficients, starts and numbers together, bold ones and timid ones.

    Coefficients that follow the numbers only afterwards creep along the valley that they share.
    """
    rows = trial.rows()
    if rows is None:
        return []
    there = [numbers.at(place + step) for step in np.diag(numbers.steps)]
    begun = [_like(trial, drift, model, trial.coef, trial.starts) for model in there]
    slopes = [
        rows.of((one.x - trial.x) / step)
        for one, step in zip(runs_of(begun), numbers.steps, strict=True)
    ]
    response = np.concatenate([rows.response, *slopes], axis=2)
    miss = rows.of(trial.miss)
    if not np.isfinite(response).all():
        return []
    found, n_coef = [], len(trial.coef)
    for damping in DAMPINGS:
        change = rows.change(response, miss, damping)
        moved = np.clip(place + change[n_coef:], numbers.low, numbers.high)
        change[n_coef:] = moved - place
        starts = trial.starts + rows.starts(response, miss, change)
        model, coef = numbers.at(moved), trial.coef + change[:n_coef]
        found.append((_like(trial, drift, model, coef, starts), moved))
    return found


def _like(trial: Trial, drift: Drift, model: Model, coef: np.ndarray, starts: np.ndarray) -> Trial:
    return replace(model.trial(coef, trial.scale, drift.part), starts=starts)


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
    numbers = _Numbers.of(model, records)
    place = np.concatenate([coef, numbers.start])
    last = len(coef) + len(numbers.free)
    drift = drift_of(model, coef, records)
    rows = None if drift is None else drift.trial.rows()
    if drift is None or rows is None:
        return np.full((last, 2), np.nan)
    trial = drift.trial
    begun = [drift.begun(numbers.at(numbers.start + step)) for step in np.diag(numbers.steps)]
    runs = runs_of([*begun, trial])[:-1]
    moved = [
        rows.of((one.x - trial.x) / step) for one, step in zip(runs, numbers.steps, strict=True)
    ]
    miss = rows.of(trial.miss)
    every = rows.freed(np.concatenate([rows.response, *moved, miss], axis=2))
    grams = np.swapaxes(every, 1, 2) @ every
    draws = rng.integers(len(grams), size=(N_RESAMPLES, len(grams)))
    changes = np.array([solve_gram(grams[draw].sum(axis=0)) for draw in draws])
    low, high = np.quantile(changes, [0.025, 0.975], axis=0) - np.median(changes, axis=0)
    intervals = place[:, None] + np.column_stack([low, high])
    intervals[len(coef) : last] = np.exp(intervals[len(coef) : last])
    return intervals[:last]


@dataclass(frozen=True, eq=False)
class _Numbers:
    """What of a model's memories is free: logarithms of their numbers, and pasts of the inputs.

    Attributes
    ----------
    model : Model
        The model with numbers to begin with.
    start : ndarray of shape (n_numbers + n_pasts,)
        Where they begin.
    low, high : ndarray
        Bounds on them.
    steps : ndarray
        Small changes, to see what they do.
    free : ndarray of int
        Places of the free numbers among all.
    given : tuple of (tuple of float)
        Pasts to begin with, of each record.
    columns : tuple of int
        Inputs whose past matters.
    """

    model: Model
    start: np.ndarray
    low: np.ndarray
    high: np.ndarray
    steps: np.ndarray
    free: np.ndarray
    given: Pasts
    columns: tuple[int, ...]

    @classmethod
    def of(cls, model: Model, records: Sequence[Record]) -> _Numbers:
        """Return what is free of a model on training records."""
        flat = np.array([value for memory in model.memories for value in memory.values])
        n_known = sum(len(memory.values) for memory in model.memories[: model.n_known])
        free = n_known + np.flatnonzero(flat[n_known:])
        logs = np.log(flat[free])
        raw = [record.raw_u for record in records]
        given = model.pasts or tuple(tuple(u[0].tolist()) for u in raw)
        columns = tuple(sorted({m.column for m in model.memories if m.has_state}))
        pasts = np.array([past[c] for past in given for c in columns])
        ends = [(u[:, c].min(), u[:, c].max()) for u in raw for c in columns]
        least, most = np.array(ends).reshape(-1, 2).T
        return cls(
            model,
            np.append(logs, pasts),
            np.append(logs - REACH, least),
            np.append(logs + REACH, most),
            np.append(np.full(len(logs), STEP), STEP * np.maximum(most - least, TINY)),
            free,
            given,
            columns,
        )

    def at(self, place: np.ndarray) -> Model:
        """Return the model with other numbers and pasts."""
        flat = np.array([value for memory in self.model.memories for value in memory.values])
        flat[self.free] = np.exp(place[: len(self.free)])
        memories, rest = [], list(flat)
        for memory in self.model.memories:
            own, rest = rest[: len(memory.values)], rest[len(memory.values) :]
            memories.append(replace(memory, values=tuple(float(value) for value in own)))
        pasts, values = [], iter(place[len(self.free) :].tolist())
        for past in self.given:
            changed = list(past)
            for column in self.columns:
                changed[column] = next(values)
            pasts.append(tuple(changed))
        return replace(self.model, memories=tuple(memories), pasts=tuple(pasts))
