"""Refine coefficients by the true simulation: multiple shooting.

The simulation fit in `fit` is linearized about the measured states. Here the model runs freely over
stretches of the record, as long as it stays close. Gauss-Newton steps change its coefficients and
the initial states of the stretches until the runs meet the record. Sensor noise enters neither the
states nor the derivatives of such a run, so it causes no bias.
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
from .trial import Trial, after_gauss_newton
from .unfolding import records_with_hidden_states, square_left, with_hidden_states

N_STRETCHES = (4, 8, 16, 32)  # to try in this order, until the model can follow
MAX_FIT_MISS = 0.5  # RMS miss of runs that are fitted, in standard deviations of a state
MAX_ROWS = 40_000  # a longer record costs too much, and its linear fit scatters little
N_STEPS = 20  # noise may have led the initial fit far astray
MIN_GAIN_SHARE = 1e-3  # stop when a step gains less than this share of the error: runs are slow

Loss = Callable[[np.ndarray], float]


def fit_by_shooting(design: Design, fitted: Fit, records: Sequence[Record]) -> Fit:
    """Return a fit whose coefficients minimize the error of free runs.

    Parameters
    ----------
    design : Design
        The model, with p columns.
    fitted : Fit
        Supplies the initial coefficients.
    records : sequence of Record
        Training records.

    Returns
    -------
    Fit
        The same one if the model cannot follow the records, or if fits to every second stretch do
        not improve the stretches in between.
    """
    loss = partial(square_left, design, records)
    coef = fit_to_runs(
        with_hidden_states(design), fitted.coef, records_with_hidden_states(design, records), loss
    )
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
        The model, with p columns and hidden states in place of its paths.
    coef : ndarray of shape (p,)
        Initial coefficients.
    records : sequence of Record
        Training records, hidden states included.
    loss : callable
        Maps coefficients to the squared residual of the derivative.

    Returns
    -------
    ndarray of shape (p,) or None
        None where `fit_by_shooting` keeps its fit, or the records are too long.
    """
    if not design.columns or sum(len(record) for record in records) > MAX_ROWS:
        return None
    records = _driven(records)
    started = _longest_trial(design, coef, records)
    if started is None or not _holds(started, records, loss):
        return None
    return _settled(started, records).coef


def gains_of_runs(few: Design, many: Design, records: Sequence[Record]) -> tuple[float, float]:
    """Return the gains of a design over a simpler one, each fitted to free runs.

    Parameters
    ----------
    few, many : Design
        The simpler one and the other.
    records : sequence of Record
        Training records; of long ones only the first rows are used.

    Returns
    -------
    runs, derivative : float
        log(squared error of the simpler one / of the other), of runs over stretches that both can
        follow, and of the derivative with the same coefficients. Infinite if the other one follows
        some stretches, but never both the same; minus infinity if it follows none.
    """
    share = min(1.0, MAX_ROWS / sum(len(record) for record in records))
    records = [record[: int(share * len(record))] for record in records]
    sides = [
        (
            with_hidden_states(d),
            refit(d, records, "derivative"),
            _driven(records_with_hidden_states(d, records)),
        )
        for d in (few, many)
    ]
    other_follows = False
    for n_stretches in N_STRETCHES:
        started = [_longest_trial(*side, (n_stretches,)) for side in sides]
        trials = [trial for trial in started if trial is not None]
        other_follows = other_follows or started[1] is not None
        if len(trials) == len(sides):
            runs = [
                _settled(t, its_records)
                for t, (_, _, its_records) in zip(trials, sides, strict=True)
            ]
            missed = [_square_missed(run, len(few.states)) for run in runs]
            errors = [
                square_left(d, records, r.coef) for d, r in zip((few, many), runs, strict=True)
            ]
            return log_ratio(*missed), log_ratio(*errors)
    return (float("inf"),) * 2 if other_follows else (-float("inf"),) * 2


def _driven(records: Sequence[Record]) -> list[Record]:
    return [driven(record) for record in records]


def _square_missed(trial: Trial, n_states: int) -> float:
    misses = (trial.miss / trial.part.state_scale)[..., :n_states]
    return float(np.sum(misses**2))


def _longest_trial(
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
            continue  # many short records give the same pieces
        length, x = part.z.shape[1], part.z[:, :, : part.n_states]
        trial = _run(Trial(design, part, part.state_scale, coef, x[:, 0], x), records)
        missed = np.sqrt(np.mean(trial.miss**2, axis=(0, 1)))
        if not np.all((missed < MAX_FIT_MISS * part.state_scale)[: trial.n_seen]):  # also for NaN
            continue
        trial = replace(trial, scale=np.maximum(missed, 1e-9 * part.state_scale))
        if trial.rows() is not None:
            return trial
    return None


def _holds(trial: Trial, records: Sequence[Record], loss: Loss) -> bool:
    """Tell whether fits to each half of the stretches improve the other half.

    If a model lacks something, wrong coefficients can improve its runs. So a loss in the derivative
    counts against the gain in the runs.
    """
    if len(trial.x) < 2:
        return False
    before, after = 0.0, 0.0
    halves = [trial.picked(slice(k, None, 2)) for k in (0, 1)]
    for seen, judged in (halves, halves[::-1]):
        coef = _settled(seen, records).coef
        before += judged.error * loss(trial.coef)
        after += _run(replace(judged, coef=coef), records).error * loss(coef)
    return after < before


def _settled(trial: Trial, records: Sequence[Record]) -> Trial:
    """Take steps until they gain nothing more."""
    (found,) = after_gauss_newton(
        [trial], lambda moved: [_run(one, records) for one in moved], MIN_GAIN_SHARE, N_STEPS
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
