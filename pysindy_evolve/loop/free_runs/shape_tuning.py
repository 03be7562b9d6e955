"""Numbers inside an effect, such as the width of a dead zone, tuned by free runs.

For each number, the slope of the effect's terms in its logarithm is added as a column. The
coefficient that a Gauss-Newton step gives to this column is the change of the logarithm.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...terms import Sum, add, constant, mul, sub
from ..effects.angles import waves_angles
from ..effects.candidate import Candidate, Shape
from ..effects.names import EVOLVED
from ..effects.shaping import shape_of
from ..evidence.scoring import columns_of
from ..fitting.trial import Trial, converged
from ..given.design import Column, Design
from .drift import Drift
from .variants import Model

N_STEPS = 2
MAX_ERROR_RATIO = 100.0  # times the least error: contenders with more are not tuned
MAX_STEP_IN_LOG = 0.7  # largest change of a logarithm in one step: a factor of two
DIFFERENCE_STEP = 1e-3  # finite difference of a logarithm


@dataclass(frozen=True, eq=False)
class Contender:
    """An effect in its model, fitted to stretches of the record by its free runs.

    If `tied`, it shares its numbers with effects of other equations, and they are not tuned.
    """

    candidate: Candidate
    trial: Trial
    tied: bool = False

    @property
    def error(self) -> float:
        """Sum of the squared misses."""
        return self.trial.error


def tuned_by_runs(contenders: Sequence[Contender], model: Model, drift: Drift) -> list[Contender]:
    """Tune the numbers inside effects, each as long as its runs come closer to the record.

    Parameters
    ----------
    contenders : sequence of Contender
        Effects, each the last one in its model.
    model : Model
        The model without them.
    drift : Drift
        Stretches and units of the errors.

    Returns
    -------
    list of Contender
        Contenders that cannot be improved stay as they are.
    """
    found = list(contenders)
    least = min(one.error for one in found)
    active = [
        k for k, one in enumerate(found) if one.error <= MAX_ERROR_RATIO * least and not one.tied
    ]
    for _ in range(N_STEPS):
        moved = {k: _moved(found[k], model, drift) for k in active}
        stepped = {k: one for k, one in moved.items() if one is not None}
        trials = converged([one.trial for one in stepped.values()])
        active = []
        for (k, one), trial in zip(stepped.items(), trials, strict=True):
            if trial.error < found[k].error:
                found[k] = Contender(one.candidate, trial)
                active.append(k)
    return found


def _moved(contender: Contender, model: Model, drift: Drift) -> Contender | None:
    """Return an effect after a step of its numbers, not run yet; None if it has no numbers."""
    shape, trial = _shape_of(contender.candidate, model.design), contender.trial
    change = None if shape is None else _with_slopes(contender, shape, model).change()
    if shape is None or change is None:
        return None
    n_coef = len(trial.coef)
    steps = np.clip(np.nan_to_num(change[0][n_coef:]), -MAX_STEP_IN_LOG, MAX_STEP_IN_LOG)
    candidate = _at(contender.candidate, shape, steps)
    stepped_model = replace(model, design=model.design.adding(columns_of(candidate, model.design)))
    coef = trial.coef + change[0][:n_coef]
    started = stepped_model.trial(coef, drift.trial.scale, drift.part)
    return Contender(candidate, replace(started, starts=trial.starts + change[1]))


def _shape_of(candidate: Candidate, design: Design) -> Shape | None:
    """Return the numbers of an effect; None if there are none to tune.

    The frequency in a named effect of an angle in radians is not tuned.
    """
    is_named = candidate.name != EVOLVED and candidate.shape is None
    if is_named and all(waves_angles(term, design) for term in candidate.terms if term.variables):
        return None
    return shape_of(candidate, design.constants)


def _at(candidate: Candidate, shape: Shape, steps: np.ndarray) -> Candidate:
    """Return an effect, and its partners, after steps of the logarithms of their numbers."""
    moved = replace(candidate, shape=shape).at((np.array(shape.values) * np.exp(steps)).tolist())
    return moved if candidate.shape is not None else replace(moved, shape=None)


def _with_slopes(contender: Contender, shape: Shape, model: Model) -> Trial:
    """Return a trial with columns added: the slopes of an effect's terms in its numbers."""
    candidate, trial = contender.candidate, contender.trial
    weights = trial.coef[len(trial.coef) - candidate.n_columns :]
    columns = slopes_of(candidate, shape, model.design, weights, DIFFERENCE_STEP)
    coef = np.append(trial.coef, np.zeros(len(columns)))
    return replace(trial, design=trial.design.adding(columns), coef=coef)


def slopes_of(
    candidate: Candidate, shape: Shape, design: Design, weights: np.ndarray, step: float
) -> list[Column]:
    """Return the slopes of the equations in the logarithm of each number inside an effect.

    Parameters
    ----------
    candidate : Candidate
        The effect.
    shape : Shape
        Its numbers.
    design : Design
        The model without it, or with it.
    weights : ndarray of shape (n_columns,)
        Coefficients of its columns, and of those of its partners.
    step : float
        Finite difference of a logarithm.

    Returns
    -------
    list of Column
        One for each number.
    """
    here = columns_of(candidate, design)
    rows = step * np.eye(len(shape.values))
    ahead = [columns_of(_at(candidate, shape, row), design) for row in rows]
    return [_slope(here, moved, (weights / step).tolist()) for moved in ahead]


def _slope(here: Sequence[Column], ahead: Sequence[Column], weights: Sequence[float]) -> Column:
    """Return the weighted sum of the differences of columns, in each equation."""
    total = [Sum(())] * len(here[0].parts)
    for column, column_ahead, weight in zip(here, ahead, weights, strict=True):
        for state, (before, after) in enumerate(zip(column.parts, column_ahead.parts, strict=True)):
            if before.parts:
                change = mul(constant(weight), sub(after, before))
                total[state] = add(total[state], change) if total[state].parts else change
    return Column("slope", tuple(total))
