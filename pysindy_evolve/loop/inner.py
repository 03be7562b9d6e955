"""Numbers inside an effect, such as the width of a dead zone, tuned by free runs.

Beside the effect stands the slope of its terms in the logarithm of each number. What coefficient
the runs give to that is how far to change the logarithm (Gauss-Newton, a few times).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial, reduce

import numpy as np

from ..signals import Record
from ..terms import Product, Sum, add, constant, mul, sub
from .candidate import Candidate, Shape
from .design import in_state
from .drift import Drift
from .scoring import columns_of
from .trial import Trial, settled
from .variants import Model

__all__ = ["Contender", "sharpened"]

N_STEPS = 3
MOST = 0.7  # change of a logarithm in one step: a factor of two
SLOPE = 1e-3  # of a logarithm, to see what it changes
MOST_NUMBERS = 3  # a term with more of them has been grown to fit noise


@dataclass(frozen=True, eq=False)
class Contender:
    """An effect in its model, fitted to stretches of the record by its free runs."""

    candidate: Candidate
    trial: Trial

    @property
    def error(self) -> float:
        """Sum of the squared misses."""
        return self.trial.error


def sharpened(
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
    active = [k for k, one in enumerate(found) if _shape_of(one.candidate) is not None]
    for _ in range(N_STEPS):
        beside = settled([_with_slopes(found[k], model) for k in active])
        moved = [_moved(found[k], trial) for k, trial in zip(active, beside, strict=True)]
        begun = [
            begin(one, model, found[k].trial, drift, records)
            for k, one in zip(active, moved, strict=True)
        ]
        after = [Contender(c, t) for c, t in zip(moved, settled(begun), strict=True)]
        better = [
            (k, one) for k, one in zip(active, after, strict=True) if one.error < found[k].error
        ]
        for k, one in better:
            found[k] = one
        active = [k for k, _ in better]
        if not active:
            break
    return found


def begin(
    candidate: Candidate, model: Model, like: Trial, drift: Drift, records: Sequence[Record]
) -> Trial:
    """Return a trial of a model with an effect that begins where another one ended."""
    whole = replace(model, design=model.design.adding(columns_of(candidate, model.design)))
    trial = whole.trial(like.coef, drift.trial.scale, records, drift.part)
    return replace(trial, starts=like.starts)


def _shape_of(candidate: Candidate) -> Shape | None:
    """Return the numbers of an effect and how to build its terms; None if it has none."""
    if candidate.shape is not None:
        return candidate.shape
    parts = [part for term in candidate.terms for part in term.parts]
    numbers = np.array(parts[0][1].constants)
    if len(parts) != 1 or not 0 < len(numbers) <= MOST_NUMBERS or not numbers.all():
        return None
    build = partial(_built, parts[0][1], np.sign(numbers))
    return Shape(tuple(np.abs(numbers).tolist()), (build,))


def _built(term: Product, signs: np.ndarray, *values: float) -> Sum:
    constants = [float(s * v) for s, v in zip(signs, values, strict=True)]
    return Sum(((1.0, term.with_constants(constants)),))


def _at(candidate: Candidate, steps: np.ndarray) -> Candidate:
    """Return an effect with the logarithms of its numbers changed."""
    shape = _shape_of(candidate)
    if shape is None:
        return candidate
    values = tuple((np.array(shape.values) * np.exp(steps)).tolist())
    there = replace(shape, values=values)
    kept = None if candidate.shape is None else there
    return replace(candidate, terms=there.terms, shape=kept)


def _with_slopes(one: Contender, model: Model) -> Trial:
    """Return a trial with the slopes of an effect's terms in its numbers beside them."""
    candidate, trial = one.candidate, one.trial
    shape = _shape_of(candidate)
    n_numbers = 0 if shape is None else len(shape.values)
    weights = trial.coef[len(trial.coef) - len(candidate.terms) :]
    columns = []
    for row in SLOPE * np.eye(n_numbers):
        pairs = zip(_at(candidate, row).terms, candidate.terms, weights, strict=True)
        slopes = [mul(constant(float(w) / SLOPE), sub(there, here)) for there, here, w in pairs]
        total = reduce(add, slopes)
        columns.append(in_state("slope", total, candidate.state, len(model.design.states)))
    coef = np.append(trial.coef, np.zeros(n_numbers))
    return replace(trial, design=trial.design.adding(columns), coef=coef)


def _moved(one: Contender, beside: Trial) -> Candidate:
    shape = _shape_of(one.candidate)
    n_numbers = 0 if shape is None else len(shape.values)
    steps = beside.coef[len(beside.coef) - n_numbers :]
    return _at(one.candidate, np.clip(np.nan_to_num(steps), -MOST, MOST))
