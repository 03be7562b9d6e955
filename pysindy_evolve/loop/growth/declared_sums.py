"""Declared sums times a function of one variable: a fan cools with the root of its speed.

A search multiplies everything out, and finds T sqrt(n) and Ta sqrt(n) one after the other at best,
where h (T - Ta) is declared and h grows with sqrt(n). Each of the two alone explains little.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from ...operators import Operator
from ...terms import Sum, mul
from ..effects.candidate import Candidate, Shape
from ..effects.names import EVOLVED
from ..effects.shaping import shape_of
from ..effects.varying_terms import parts_of
from ..evidence.scoring import net, score, tuned
from ..given.design import Design
from ..given.segments import Segments
from .curves import curves
from .seeds import functions

N_BEST = 3  # products to tune and to return


def sums_times_functions(
    design: Design, state: int, part: Segments, operators: Sequence[Operator], x: np.ndarray
) -> list[Candidate]:
    """Return the best products of a declared sum of one equation and a function of one variable.

    Parameters
    ----------
    design : Design
        The model so far.
    state : int
        The equation.
    part : Segments
        Pieces to search in.
    operators : sequence of Operator
        Basis functions; without ``mul`` there are no products.
    x : ndarray of shape (n, n_variables)
        Measured variables, without the time.

    Returns
    -------
    list of Candidate
        Their numbers are tuned. A declared sum is known, so it costs one node only.
    """
    sums = [one for one in parts_of(design, state) if len(one.parts) > 1]
    if not sums or not any(operator.name == "mul" for operator in operators):
        return []
    factors = [*functions(operators, x), *curves(operators, x, len(design.states))]
    offered = [c for one in sums for c in _products(one, factors, state, design)]
    best = [tuned(one, design, part) for one in _best(offered, design, part)]
    return _best(best, design, part)


def _best(offered: Sequence[Candidate], design: Design, part: Segments) -> list[Candidate]:
    """Return the few candidates that gain most for their nodes, best first."""
    scores = score(design, part, list(dict.fromkeys(offered)), pairs=False)
    worth = sorted((s for s in scores if net(s) > 0.0), key=net, reverse=True)
    return [s.group[0] for s in worth[:N_BEST]]


def _products(
    declared: Sum, factors: Sequence[Sum], state: int, design: Design
) -> Iterator[Candidate]:
    """Yield products of a sum and functions, whose numbers are those of the function."""
    for branch, factor in enumerate(factors):
        alone = Candidate(EVOLVED, state, (factor,))
        shape, term = shape_of(alone, design.constants), mul(declared, factor)
        if shape is not None:
            builds = (partial(_times, declared, shape.builds[0]),)
            shape = Shape(shape.values, builds, branch=branch)
        whole = Candidate(EVOLVED, state, (term,), shape=shape)
        yield replace(whole, free_nodes=whole.size - alone.size - 1)


def _times(declared: Sum, build: Callable[..., Sum], *values: float) -> Sum:
    """Return a declared sum times a function with these numbers."""
    return mul(declared, build(*values))
