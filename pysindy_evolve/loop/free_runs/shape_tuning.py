"""Numbers inside an effect, such as the width of a dead zone, tuned by free runs.

Beside the effect stands the slope of its terms in the logarithm of each number. The coefficient
that a Gauss-Newton step gives to it is how far to change the logarithm.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import reduce

import numpy as np

from ...signals import Record
from ...terms import add, constant, mul, sub
from ..effects.candidate import Candidate, Shape
from ..effects.shaping import shape_of
from ..evidence.scoring import columns_of
from ..fitting.trial import Trial, settled
from ..given.design import in_state
from .drift import Drift
from .variants import Model

__all__ = ["Contender", "tuned_by_runs"]

N_STEPS = 2
FAR = 4.0  # times the least error: an effect that misses by more will not catch up
MOST = 0.7  # change of a logarithm in one step: a factor of two
SLOPE = 1e-3  # of a logarithm, to see what it changes


@dataclass(frozen=True, eq=False)
class Contender:
    """An effect in its model, fitted to stretches of the record by its free runs."""

    candidate: Candidate
    trial: Trial

    @property
    def error(self) -> float:
        """Sum of the squared misses."""
        return self.trial.error


def tuned_by_runs(
    contenders: Sequence[Contender], model: Model, drift: Drift, records: Sequence[Record]
) -> list[Contender]:
    """Tune the numbers inside effects, as long as their runs come closer to the record.

    Parameters
    ----------
    contenders : sequence of Contender
        Effects, each the last one in its model.
    model : Model
        The model without them.
    drift : Drift
        Stretches and units of the errors.
    records : sequence of Record
        Training records, without memories.

    Returns
    -------
    list of Contender
        The same ones where there is nothing to tune.
    """
    found = list(contenders)
    least = min(one.error for one in found)
    active = [k for k, one in enumerate(found) if one.error <= FAR * least]
    for _ in range(N_STEPS):
        moved = {k: _moved(found[k], model, drift, records) for k in active}
        begun = {k: one for k, one in moved.items() if one is not None}
        trials = settled([one.trial for one in begun.values()])
        active = []
        for (k, one), trial in zip(begun.items(), trials, strict=True):
            if trial.error < found[k].error:
                found[k] = Contender(one.candidate, trial)
                active.append(k)
    return found


def _moved(
    one: Contender, model: Model, drift: Drift, records: Sequence[Record]
) -> Contender | None:
    """Return an effect with its numbers a step further, not run yet; None if it has none."""
    shape, trial = shape_of(one.candidate), one.trial
    change = None if shape is None else _with_slopes(one, shape, model).change()
    if shape is None or change is None:
        return None
    n_own = len(trial.coef)
    steps = np.clip(np.nan_to_num(change[0][n_own:]), -MOST, MOST)
    candidate = _at(one.candidate, shape, steps)
    whole = replace(model, design=model.design.adding(columns_of(candidate, model.design)))
    coef = trial.coef + change[0][:n_own]
    begun = whole.trial(coef, drift.trial.scale, records, drift.part)
    return Contender(candidate, replace(begun, starts=trial.starts + change[1]))


def _at(candidate: Candidate, shape: Shape, steps: np.ndarray) -> Candidate:
    """Return an effect with the logarithms of its numbers changed."""
    values = tuple((np.array(shape.values) * np.exp(steps)).tolist())
    there = replace(shape, values=values)
    kept = None if candidate.shape is None else there
    return replace(candidate, terms=there.terms, shape=kept)


def _with_slopes(one: Contender, shape: Shape, model: Model) -> Trial:
    """Return a trial with the slopes of an effect's terms in its numbers beside them."""
    candidate, trial = one.candidate, one.trial
    weights = trial.coef[len(trial.coef) - len(candidate.terms) :]
    columns = []
    for row in SLOPE * np.eye(len(shape.values)):
        pairs = zip(_at(candidate, shape, row).terms, candidate.terms, weights, strict=True)
        slopes = [mul(constant(float(w) / SLOPE), sub(there, here)) for there, here, w in pairs]
        total = reduce(add, slopes)
        columns.append(in_state("slope", total, candidate.state, len(model.design.states)))
    coef = np.append(trial.coef, np.zeros(len(columns)))
    return replace(trial, design=trial.design.adding(columns), coef=coef)
