"""Refine coefficients by the true simulation: multiple shooting.

The fit of the simulation error in `fit` is linear, about the measured states. Here the model runs
by itself over stretches of the record, as long as it stays close, and Gauss-Newton steps change its
coefficients, and the states in which the stretches begin, until it meets what was measured. Noise
of the sensor enters neither the states nor their derivatives of such a run, and biases nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from ...signals import Record
from ..given.band import driven
from ..given.design import Design
from ..given.segments import segments
from ..given.sticking import may_rest
from .fit import Fit, refit
from .linear import log_ratio
from .runs import free_run
from .trial import Trial, bettered
from .unfolding import square_left, unfolded, with_paths

__all__ = ["fit_by_shooting", "fit_to_runs", "gains_of_runs"]

N_STRETCHES = (4, 8, 16, 32)  # of the training data; the fewest that the model can follow
FAITHFUL = 0.5  # standard deviations by which a run may miss
MAX_ROWS = 40_000  # a longer record costs too much, and its linear fit scatters little
N_STEPS = 20  # a fit that noise has led far astray needs many
SETTLED = 1e-3  # relative gain of a step after which no other one is taken: runs cost much time

Loss = Callable[[np.ndarray], float]


def fit_by_shooting(design: Design, fitted: Fit, records: Sequence[Record]) -> Fit:
    """Return a fit whose coefficients minimize the error of free runs.

    Parameters
    ----------
    design : Design
        The model, with p columns.
    fitted : Fit
        Coefficients to begin with.
    records : sequence of Record
        Training records.

    Returns
    -------
    Fit
        The same one where the model cannot follow the records, or where what every second stretch
        says does not hold on those between.
    """
    loss = partial(square_left, design, records)
    coef = fit_to_runs(unfolded(design), fitted.coef, with_paths(design, records), loss)
    if coef is None:
        return fitted
    intervals = fitted.intervals + (coef - fitted.coef)[:, None]
    return Fit(coef, intervals, "simulation")


def fit_to_runs(
    design: Design, coef: np.ndarray, records: Sequence[Record], loss: Loss
) -> np.ndarray | None:
    """Return the coefficients whose free runs meet records best.

    Parameters
    ----------
    design : Design
        The model, with p columns, unfolded.
    coef : ndarray of shape (p,)
        Where to begin.
    records : sequence of Record
        Training records, with the paths that hidden states take.
    loss : callable
        Maps coefficients to the sum of squares that they leave of the derivative.

    Returns
    -------
    ndarray of shape (p,) or None
        None as described in `fit_by_shooting`.
    """
    if not design.columns or sum(len(record) for record in records) > MAX_ROWS:
        return None
    records = _driven(records)
    begun = _begun(design, coef, records)
    if begun is None or not _holds(begun, records, loss):
        return None
    return _settled(begun, records).coef


def gains_of_runs(few: Design, many: Design, records: Sequence[Record]) -> tuple[float, float]:
    """Return by how much one design comes closer than a simpler one, each fitted to free runs.

    Parameters
    ----------
    few, many : Design
        The simpler one and the other.
    records : sequence of Record
        Training records; of long ones the first rows are looked at.

    Returns
    -------
    runs, derivative : float
        log(squares that the simpler one misses / the other), of runs over stretches that both can
        follow, and of the derivative with the coefficients of these. Infinite where the simpler one
        can follow none, and minus infinity where the other cannot.
    """
    share = min(1.0, MAX_ROWS / sum(len(record) for record in records))
    records = [record[: int(share * len(record))] for record in records]
    sides = [
        (unfolded(d), refit(d, records, "derivative"), _driven(with_paths(d, records)))
        for d in (few, many)
    ]
    ever = False
    for n_stretches in N_STRETCHES:
        begun = [_begun(*side, (n_stretches,)) for side in sides]
        trials = [trial for trial in begun if trial is not None]
        ever = ever or begun[1] is not None
        if len(trials) == len(sides):
            runs = [_settled(t, own) for t, (_, _, own) in zip(trials, sides, strict=True)]
            missed = [_square_missed(run, len(few.states)) for run in runs]
            left = [square_left(d, records, r.coef) for d, r in zip((few, many), runs, strict=True)]
            return log_ratio(*missed), log_ratio(*left)
    return (float("inf"),) * 2 if ever else (-float("inf"),) * 2


def _driven(records: Sequence[Record]) -> list[Record]:
    return [driven(record) for record in records]


def _square_missed(trial: Trial, n_states: int) -> float:
    misses = (trial.miss / trial.part.state_scale)[..., :n_states]
    return float(np.sum(misses**2))


def _begun(
    design: Design,
    coef: np.ndarray,
    records: Sequence[Record],
    numbers: Sequence[int] = N_STRETCHES,
) -> Trial | None:
    """Run over the longest stretches that a model can follow; None if there are none."""
    length = 0
    for n_stretches in numbers:
        part = segments(records, may_rest(design, records), n_stretches, max_rows=None)
        if part.z.shape[1] == length:
            continue  # many short records are cut alike
        length, x = part.z.shape[1], part.z[:, :, : part.n_states]
        trial = _run(Trial(design, part, part.state_scale, coef, x[:, 0], x), records)
        missed = np.sqrt(np.mean(trial.miss**2, axis=(0, 1)))
        if not np.all((missed < FAITHFUL * part.state_scale)[: trial.n_seen]):  # so too for NaN
            continue
        trial = replace(trial, scale=np.maximum(missed, 1e-9 * part.state_scale))
        if trial.rows() is not None:
            return trial
    return None


def _holds(begun: Trial, records: Sequence[Record], loss: Loss) -> bool:
    """Tell whether steps on one half of the stretches better the other half, and the reverse.

    Where a model lacks something, runs can be bettered by coefficients that are wrong. So what the
    derivative loses counts against what the runs gain.
    """
    if len(begun.x) < 2:
        return False
    before, after = 0.0, 0.0
    halves = [begun.picked(slice(k, None, 2)) for k in (0, 1)]
    for seen, judged in (halves, halves[::-1]):
        coef = _settled(seen, records).coef
        before += judged.error * loss(begun.coef)
        after += _run(replace(judged, coef=coef), records).error * loss(coef)
    return after < before


def _settled(trial: Trial, records: Sequence[Record]) -> Trial:
    """Take steps until they gain nothing more."""
    (found,) = bettered(
        [trial], lambda moved: [_run(one, records) for one in moved], SETTLED, N_STEPS
    )
    return found


def _run(trial: Trial, records: Sequence[Record]) -> Trial:
    """Run over all stretches, sticking where a body sticks; NaN from where a run diverges."""
    length, equations = trial.part.z.shape[1], trial.design.equations(trial.coef)
    pieces = (records[i][row : row + length] for i, row in trial.part.places)
    runs = [
        free_run(equations, piece, start, on_divergence="nan", tolerance=1e-6)
        for piece, start in zip(pieces, trial.starts, strict=True)
    ]
    return replace(trial, x=np.array(runs))
