"""Tune the numbers of memories by free runs, together with the coefficients."""

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
from .drift import N_LONG_STRETCHES, Drift, drift_of
from .variants import Model, Pasts

# Finite difference: of log(number), or of a past input relative to its range.
DIFFERENCE_STEP = 0.02
REACH_IN_LOG = 1.5  # how far a logarithm may move from its start: a factor of 4.5
MAX_STEPS = 50
MIN_GAIN_SHARE = 1e-4  # stop when a step gains less than this share of the error
DAMPINGS = (1e-6, 1e-4, 1e-3, 1e-2, 0.1, 1.0, 10.0)  # tried in each step, see `Rows.change`
N_RESAMPLES = 400  # draws of stretches for the intervals


def tuned_memories(drift: Drift, model: Model) -> Model:
    """Return a model with delays, time constants, brims and shares tuned; a share of zero stays.

    The inputs before each record, which hidden states remember, are tuned too.

    Parameters
    ----------
    drift : Drift
        Stretches of the record.
    model : Model
        Its memories have numbers from a grid.

    Returns
    -------
    Model
    """
    numbers = _Numbers.of(model, drift.records)
    if not len(numbers.start):
        return model
    initial = drift.trial_of(numbers.at(numbers.start))
    (current,), place = converged([initial]), numbers.start
    for _ in range(MAX_STEPS):
        tried = _steps(drift, current, numbers, place) if np.isfinite(current.error) else []
        moved = runs_of([trial for trial, _ in tried])
        best = min(range(len(moved)), key=lambda k: moved[k].error, default=None)
        gain = 0.0 if best is None else 1.0 - moved[best].error / max(current.error, TINY)
        if best is not None and gain > 0.0:
            current, place = moved[best], tried[best][1]
        if gain < MIN_GAIN_SHARE:
            break
    return numbers.at(place)


def _steps(
    drift: Drift, trial: Trial, numbers: _Numbers, place: np.ndarray
) -> list[tuple[Trial, np.ndarray]]:
    """Return a trial and its numbers after a joint step of all parameters, for each damping.

    If the coefficients were refitted only after each step of the numbers, the two would creep along
    their common valley.
    """
    rows = trial.rows()
    if rows is None:
        return []
    ahead = [numbers.at(place + step) for step in np.diag(numbers.steps)]
    started = [_like(trial, drift, model, trial.coef, trial.starts) for model in ahead]
    slopes = [
        rows.of((run.x - trial.x) / step)
        for run, step in zip(runs_of(started), numbers.steps, strict=True)
    ]
    response = np.concatenate([rows.response, *slopes], axis=2)
    miss = rows.of(trial.miss)
    if not np.isfinite(response).all():
        return []
    stepped, n_coef = [], len(trial.coef)
    for damping in DAMPINGS:
        change = rows.change(response, miss, damping)
        moved = np.clip(place + change[n_coef:], numbers.low, numbers.high)
        change[n_coef:] = moved - place
        starts = trial.starts + rows.starts(response, miss, change)
        model, coef = numbers.at(moved), trial.coef + change[:n_coef]
        stepped.append((_like(trial, drift, model, coef, starts), moved))
    return stepped


def _like(trial: Trial, drift: Drift, model: Model, coef: np.ndarray, starts: np.ndarray) -> Trial:
    return replace(model.trial(coef, trial.scale, drift.part), starts=starts)


def fit_by_runs(
    design: Design, fitted: Fit, records: Sequence[Record], rng: np.random.Generator
) -> Fit:
    """Return coefficients fitted to free runs over stretches; the same fit if these fail.

    Parameters
    ----------
    design : Design
        The model, limits included.
    fitted : Fit
        Supplies the initial coefficients.
    records : sequence of Record
        Training records, with inputs as they act.
    rng : numpy.random.Generator
        Draws the stretches of the intervals.

    Returns
    -------
    Fit
    """
    long = drift_of(Model(design), fitted.coef, records, N_LONG_STRETCHES)
    if long is None:
        return fitted
    intervals = intervals_by_runs(Model(design), long.trial.coef, records, rng)
    return Fit(long.trial.coef, intervals, "simulation")


def intervals_by_runs(
    model: Model, coef: np.ndarray, records: Sequence[Record], rng: np.random.Generator
) -> np.ndarray:
    """Return the 95 % intervals of the coefficients and then of the numbers of memories.

    Stretches are drawn with replacement, and all parameters are fitted to each draw to first order.
    The quantiles about the median are centered on the fitted values. NaN if runs fail.

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
    started = [drift.trial_of(numbers.at(numbers.start + step)) for step in np.diag(numbers.steps)]
    runs = runs_of([*started, trial])[:-1]
    slopes = [
        rows.of((run.x - trial.x) / step) for run, step in zip(runs, numbers.steps, strict=True)
    ]
    miss = rows.of(trial.miss)
    all_columns = rows.without_starts(np.concatenate([rows.response, *slopes, miss], axis=2))
    grams = np.swapaxes(all_columns, 1, 2) @ all_columns
    draws = rng.integers(len(grams), size=(N_RESAMPLES, len(grams)))
    changes = np.array([solve_gram(grams[draw].sum(axis=0)) for draw in draws])
    low, high = np.quantile(changes, [0.025, 0.975], axis=0) - np.median(changes, axis=0)
    intervals = place[:, None] + np.column_stack([low, high])
    intervals[len(coef) : last] = np.exp(intervals[len(coef) : last])
    return intervals[:last]


@dataclass(frozen=True, eq=False)
class _Numbers:
    """Free parameters of a model's memories: logarithms of numbers, and inputs before records.

    Attributes
    ----------
    model : Model
        The model with its initial numbers.
    start : ndarray of shape (n_numbers + n_pasts,)
        Initial values of the parameters.
    low, high : ndarray
        Bounds on the parameters.
    steps : ndarray
        Finite differences.
    free : ndarray of int
        Places of the free numbers among all numbers.
    given : tuple of (tuple of float)
        Initial guess of the inputs before each record.
    columns : tuple of int
        Inputs that a hidden state remembers.
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
        """Return the free parameters of a model on training records."""
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
            np.append(logs - REACH_IN_LOG, least),
            np.append(logs + REACH_IN_LOG, most),
            np.append(
                np.full(len(logs), DIFFERENCE_STEP),
                DIFFERENCE_STEP * np.maximum(most - least, TINY),
            ),
            free,
            given,
            columns,
        )

    def at(self, place: np.ndarray) -> Model:
        """Return the model with other values of the parameters."""
        flat = np.array([value for memory in self.model.memories for value in memory.values])
        flat[self.free] = np.exp(place[: len(self.free)])
        memories, rest = [], list(flat)
        for memory in self.model.memories:
            values_of_memory, rest = rest[: len(memory.values)], rest[len(memory.values) :]
            memories.append(
                replace(memory, values=tuple(float(value) for value in values_of_memory))
            )
        pasts, values = [], iter(place[len(self.free) :].tolist())
        for past in self.given:
            changed = list(past)
            for column in self.columns:
                changed[column] = next(values)
            pasts.append(tuple(changed))
        return replace(self.model, memories=tuple(memories), pasts=tuple(pasts))
