"""How far free runs drift from the record, and which models drift less.

Variants of a model are fitted to stretches of the record by their free runs, and predict the
stretches that were held out. Twins show what chance gains: a twin is the runs of the present model
plus their misses, with a random sign for each stretch. These misses are as large and as colored as
the measured ones, but no longer a function of the input. Signs may differ between stretches, since
each run starts from its own state and no disturbance carries over.

References
----------
Cameron, Gelbach and Miller, Rev. Econ. Stat. 90 (2008), DOI 10.1162/rest.90.3.414: the signs.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...signals import Record
from ..fitting.residual import MAX_GROWTH
from ..fitting.trial import Trial, converged
from ..given.design import Column
from ..given.segments import Segments, segments
from ..given.sticking import may_rest
from .heldout import HeldOut
from .variants import Model
from .whitening import Whitener

N_STRETCHES = (16, 32)  # to try in this order; 16 signs already allow many different draws
N_LONG_STRETCHES = (4, 8, 16, 32)  # the same for tuning numbers: slow effects show in long runs
MAX_ROWS = 9600  # of all stretches together; limits the cost of a run
CHUNK = 200  # terms evaluated at a time, so that memory does not grow with their number
MAX_DRIFT_MISS = 1.0  # RMS miss of runs that are compared, in standard deviations of a state


@dataclass(frozen=True, eq=False)
class Drift:
    """The present model, fitted to stretches by its free runs.

    Attributes
    ----------
    model : Model
        The model.
    part : Segments
        Stretches of the training records, before memories are applied.
    trial : Trial
        The runs.
    whitener : Whitener
        Removes from their misses what earlier misses predict.
    """

    model: Model
    part: Segments
    trial: Trial
    whitener: Whitener

    @property
    def records(self) -> tuple[Record, ...]:
        """Training records, before memories are applied."""
        return self.part.records

    @property
    def views(self) -> tuple[Whitener | None, ...]:
        """The two views of the misses: as they are (None), and whitened."""
        return None, self.whitener

    @property
    def left(self) -> np.ndarray:
        """Misses of the runs, record minus run, shape (n_stretches, n, n_states)."""
        return np.asarray(self.trial.miss)

    @property
    def in_twins(self) -> Trial:
        """The trial with its own runs as target: the twin without noise."""
        return self.trial.aimed_at(self.trial.shown)

    def trial_of(self, model: Model) -> Trial:
        """Return a trial of another model, with the coefficients and starts of this one."""
        old = self.trial
        coef = np.zeros(len(model.design.columns))
        coef[: len(old.coef)] = old.coef[: len(coef)]
        return replace(model.trial(coef, old.scale, self.part), starts=old.starts)


def drift_of(
    model: Model,
    coef: np.ndarray,
    records: Sequence[Record],
    n_stretches: Sequence[int] = N_STRETCHES,
    most_growth: float = MAX_GROWTH,
) -> Drift | None:
    """Fit a model to the longest stretches that it can follow; None if there are none.

    Parameters
    ----------
    model : Model
        The model, with p coefficients.
    coef : ndarray of shape (p,)
        Initial coefficients.
    records : sequence of Record
        Training records, before memories are applied.
    n_stretches : sequence of int
        Numbers of stretches to try, in order.
    most_growth : float
        Largest factor by which a small deviation may grow along a typical (median) stretch, unless
        it grows at once and no further.

    Returns
    -------
    Drift or None
    """
    for n in n_stretches:
        part = segments(records, may_rest(model.design, records), n, MAX_ROWS)
        (trial,) = converged([model.trial(coef, part.state_scale, part)])
        rows = trial.rows(most_growth)
        with np.errstate(over="ignore"):  # where runs diverge
            missed = np.sqrt(np.mean(trial.miss**2, axis=(0, 1)))
        if rows is not None and np.all(missed < MAX_DRIFT_MISS * part.state_scale):
            misses = rows.without_starts(rows.of(trial.miss))
            trial = replace(trial, scale=np.maximum(missed, 1e-9 * part.state_scale))
            stride = max(1, round(0.5 / (part.cutoff * part.dt * rows.keep)))
            whitener = Whitener.of(misses.reshape(len(misses), -1, part.n_states), stride)
            return None if whitener is None else Drift(model, part, trial, whitener)
    return None


def gains_of_models(drift: Drift, models: Sequence[Model]) -> np.ndarray:
    """Return log(error of the present model / error of another) for each other model, fitted.

    Parameters
    ----------
    drift : Drift
        The present model.
    models : sequence of Model
        The other models.

    Returns
    -------
    ndarray of shape (n_views, n_models)
        Held-out gains of the plain and of the whitened misses; minus infinity for models that
        cannot be run.
    """
    unsigned = np.ones((1, len(drift.part.z)))
    trials = converged([drift.trial_of(model) for model in models])
    gains = np.full((len(drift.views), len(models)), -np.inf)
    for row, whitener in zip(gains, drift.views, strict=True):
        before = _log_errors(drift.trial, None, whitener, unsigned)[0]
        for k, trial in enumerate(trials):
            after = _log_errors(trial, None, whitener, unsigned)[0]
            if np.isfinite(after):
                row[k] = before - after
    return gains


def chance_of_models(drift: Drift, models: Sequence[Model], signs: np.ndarray) -> np.ndarray:
    """Return the largest gain of all models in each twin.

    Each model is fitted once, to the noise-free run that all twins share.

    Parameters
    ----------
    drift : Drift
        The present model, which is the truth in the twins.
    models : sequence of Model
        The models that were tried on the record.
    signs : ndarray of shape (n_twins, n_stretches)
        Signs of the present model's misses.

    Returns
    -------
    ndarray of shape (n_views, n_twins)
    """
    started = [drift.trial_of(model).aimed_at(drift.trial.shown) for model in models]
    trials, misses = converged(started), drift.left
    largest = []
    for whitener in drift.views:
        errors = [_log_errors(trial, misses, whitener, signs) for trial in trials]
        least = np.min([np.full(len(signs), np.inf), *errors], axis=0)
        largest.append(_log_errors(drift.in_twins, misses, whitener, signs) - least)
    return np.array(largest)


def gains_of_terms(
    drift: Drift, groups: Sequence[tuple[Column, ...]], n_replaced: int = 0
) -> np.ndarray:
    """Return log(error without a group / error with it) for each group of columns.

    Runs are linearized in the coefficients, so no further runs are needed.

    Parameters
    ----------
    drift : Drift
        The present model.
    groups : sequence of tuple of Column
        Columns that each term adds to the design.
    n_replaced : int
        Number of the model's last columns that a group replaces.

    Returns
    -------
    ndarray of shape (n_groups,)
        Held-out gains; minus infinity for groups that cannot be run, or depend linearly on the
        model's columns.
    """
    gains, unsigned = np.full(len(groups), -np.inf), np.ones((1, len(drift.part.z)))
    for chunk in _chunks(groups):
        record = HeldOut.of(_with_columns(drift.trial, groups[chunk]))
        if record is not None:
            gains[chunk] = _gains(record, drift, groups[chunk], unsigned, n_replaced)[:, 0]
    return gains


def chance_of_terms(
    drift: Drift, groups: Sequence[tuple[Column, ...]], signs: np.ndarray
) -> np.ndarray:
    """Return the largest gain of all groups of columns in each twin.

    Parameters
    ----------
    drift : Drift
        The present model, which is the truth in the twins.
    groups : sequence of tuple of Column
        Columns that each term adds to the design.
    signs : ndarray of shape (n_twins, n_stretches)
        Signs of the present model's misses.

    Returns
    -------
    ndarray of shape (n_twins,)
    """
    largest = np.full(len(signs), -np.inf)
    for chunk in _chunks(groups):
        twins = HeldOut.of(_with_columns(drift.in_twins, groups[chunk]), drift.left)
        if twins is not None:
            largest = np.maximum(largest, _gains(twins, drift, groups[chunk], signs).max(axis=0))
    return largest


def _chunks(groups: Sequence[tuple[Column, ...]]) -> list[slice]:
    return [slice(i, i + CHUNK) for i in range(0, len(groups), CHUNK)]


def _gains(
    view: HeldOut,
    drift: Drift,
    groups: Sequence[tuple[Column, ...]],
    signs: np.ndarray,
    n_replaced: int = 0,
) -> np.ndarray:
    """Return the log gain of each group for each draw of signs, shape (n_groups, n_draws)."""
    n_present = len(drift.trial.coef)
    before, kept = np.log(view.errors(signs, range(n_present))), range(n_present - n_replaced)
    gains = np.full((len(groups), len(signs)), -np.inf)
    ends = n_present + np.cumsum([len(group) for group in groups], dtype=int)
    for row, group, end in zip(gains, groups, ends.tolist(), strict=True):
        new = range(end - len(group), end)
        if view.is_new(len(kept), new):
            row[:] = before - np.log(view.errors(signs, [*kept, *new]))
    return gains


def _with_columns(trial: Trial, groups: Sequence[tuple[Column, ...]]) -> Trial:
    columns = [column for group in groups for column in group]
    coef = np.append(trial.coef, np.zeros(len(columns)))
    return replace(trial, design=trial.design.adding(columns), coef=coef)


def _log_errors(
    trial: Trial, noise: np.ndarray | None, whitener: Whitener | None, signs: np.ndarray
) -> np.ndarray:
    """Return the logarithms of held-out errors; infinite if the trial cannot be run."""
    view = HeldOut.of(trial, noise, whitener)
    return np.full(len(signs), np.inf) if view is None else np.log(view.errors(signs))
