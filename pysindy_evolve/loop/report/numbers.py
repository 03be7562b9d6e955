"""How sure the numbers are of what remembers a state, and what that leaves of its coefficient.

What a small change of a number does to the rates is one more column of the model; the interval of
that column's coefficient is how far the number could be off. Where a record cannot tell a time of
relaxation from how strongly it acts, both intervals are wide. Other coefficients are given these
numbers.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...signals import Record
from ...terms import Sum, as_sum, constant, mul, sub
from ..effects.candidate import Candidate, Shape
from ..fitting.fit import derivative_intervals
from ..given.design import Design, in_state
from .effect import Effect

__all__ = ["with_number_intervals"]

STEP = 0.02  # of a number, to see what it changes


def with_number_intervals(
    effect: Effect,
    candidate: Candidate,
    place: int,
    design: Design,
    coef: np.ndarray,
    acted: Sequence[Record],
    rng: np.random.Generator,
) -> Effect:
    """Return an effect whose intervals say what its coefficient and numbers may be together.

    Parameters
    ----------
    effect : Effect
        With the interval that its coefficient has if the numbers are right.
    candidate : Candidate
        The effect; one that remembers no state, or whose numbers are fixed, stays as it is.
    place : int
        Its column in the design.
    design : Design
        The whole model, with p columns.
    coef : ndarray of shape (p,)
        Its coefficients.
    acted : sequence of Record
        Training records with what acts.
    rng : numpy.random.Generator
        Draws the blocks.

    Returns
    -------
    Effect
    """
    shape = candidate.shape
    if shape is None or not _remembers(candidate, design):
        return effect
    values = np.array(shape.values)
    changes = [
        in_state("change", mul(constant(coef[place]), slope), candidate.state, len(design.states))
        for slope in _slopes(shape)
    ]
    ends = derivative_intervals(design.adding(changes), acted, rng)
    half = 0.5 * (ends[:, 1] - ends[:, 0])[:, None] * [-1.0, 1.0]
    known = effect.confidence_intervals
    own = coef[place] + half[[place]]
    return replace(
        effect,
        confidence_intervals=np.column_stack(
            [np.minimum(known[:, 0], own[:, 0]), np.maximum(known[:, 1], own[:, 1])]
        ),
        number_intervals=np.maximum(values[:, None] + half[len(design.columns) :], 0.0),
    )


def _slopes(shape: Shape) -> list[Sum]:
    """Return what the term of a shape changes with each of its numbers, per unit of it."""
    found = []
    for k, value in enumerate(shape.values):
        further = (*shape.values[:k], (1.0 + STEP) * value, *shape.values[k + 1 :])
        change = sub(replace(shape, values=further).terms[0], shape.terms[0])
        found.append(mul(constant(1.0 / (STEP * value)), change))
    return found


def _remembers(candidate: Candidate, design: Design) -> bool:
    """Tell whether an effect is one of the paths of a design, see path_states.py."""
    return candidate.terms in [(as_sum(path),) for path in design.paths]
