"""Products with declared sums, and functions of them: a fan cools with the root of its speed.

A search multiplies everything out, and finds T sqrt(n) and Ta sqrt(n) one after the other at best,
where h (T - Ta) is declared and h grows with sqrt(n). Each of the two alone explains little. It
does not add inside a function either, as newtons and meters do not add: but what is declared as a
sum does, such as the stretch of a coupling between two shafts.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from ...operators import Operator
from ...substitution import substituted
from ...terms import Sum, Variable, constant, mul
from ..effects.candidate import OFFSET, Candidate, Shape
from ..effects.missing import terms_in
from ..effects.names import EVOLVED
from ..effects.shaping import offset_of, shape_of
from ..effects.varying_terms import parts_of
from ..evidence.scoring import net, score, tuned
from ..given.design import Design
from ..given.segments import Segments
from .curves import curves
from .naming import has_arbitrary_zero, poses_as_offset
from .seeds import CHUNK, functions

N_TUNED = 12  # terms to tune: the right form may be far from its numbers on the grid
N_BEST = 3  # terms to return, each of another form
ALONE = constant(1.0)


def terms_with_sums(
    design: Design, state: int, part: Segments, operators: Sequence[Operator], x: np.ndarray
) -> list[Candidate]:
    """Return the best terms with a declared sum of one equation in them.

    These are a sum times a function of one variable or of a sum, and a function of a sum.

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
    sums = [one for one in parts_of(design, state) if _is_sum(one, design.time)]
    if not sums or not any(operator.name == "mul" for operator in operators):
        return []
    of_variables = [*functions(operators, x), *curves(operators, x, len(design.states))]
    offered = [c for base in sums for c in _products(base, of_variables, None, state, design)]
    for argument in (_made_positive(one, x) for one in sums):
        column = argument.evaluate(x)[:, None]
        of_sum = [*functions(operators, column), *curves(operators, column, 0)]
        for base in (ALONE, *sums):
            offered += _products(base, of_sum, argument, state, design)
    offered = list(dict.fromkeys(offered))
    if (state, OFFSET) not in terms_in(design):
        signed = has_arbitrary_zero(design, state, part.ranges.signed)
        posing = [one for one in offered if poses_as_offset(one.terms[0], x, signed)]
        offered += map(_beside_offset, posing)
    chunks = [offered[i : i + CHUNK] for i in range(0, len(offered), CHUNK)]
    best = [one for chunk in chunks for one in _best(chunk, design, part)[:N_TUNED]]
    sharp = [tuned(one, design, part) for one in _best(best, design, part)[:N_TUNED]]
    forms: dict[object, Candidate] = {}
    for one in _best(sharp, design, part):
        forms.setdefault(one.form, one)
    return list(forms.values())[:N_BEST]


def _made_positive(argument: Sum, x: np.ndarray) -> Sum:
    """Return a sum with the sign in which it is positive, if it keeps its sign."""
    is_negative = bool((argument.evaluate(x) < 0.0).all())
    return mul(constant(-1.0), argument) if is_negative else argument


def _beside_offset(candidate: Candidate) -> Candidate:
    """Return a candidate with a constant as one more column: a spring exp(q - z) - 1 rests at 0."""
    shape = candidate.shape
    if shape is not None:
        shape = replace(shape, builds=(*shape.builds, offset_of))
    return replace(candidate, terms=(*candidate.terms, OFFSET), shape=shape)


def _is_sum(part: Sum, time: int) -> bool:
    """Tell whether a part is a sum of variables and products of them, and not of functions."""
    atoms = (atom for _, term in part.parts for atom, _ in term.factors)
    plain = all(isinstance(atom, Variable) and atom.index != time for atom in atoms)
    return plain and len(part.parts) > 1


def _best(offered: Sequence[Candidate], design: Design, part: Segments) -> list[Candidate]:
    """Return the candidates that are worth their nodes, best first."""
    scores = score(design, part, offered, pairs=False)
    worth = sorted((s for s in scores if net(s) > 0.0), key=net, reverse=True)
    return [s.group[0] for s in worth]


def _products(
    base: Sum, factors: Sequence[Sum], argument: Sum | None, state: int, design: Design
) -> Iterator[Candidate]:
    """Yield a base times functions; with an argument, that is put in for their first variable."""
    for branch, factor in enumerate(factors):
        alone = Candidate(EVOLVED, state, (factor,))
        shape = shape_of(alone, design.constants)
        if shape is not None:
            builds = (partial(_built, base, argument, shape.builds[0]),)
            shape = Shape(shape.values, builds, branch=branch)
        whole = Candidate(EVOLVED, state, (_times(base, argument, factor),), shape=shape)
        wanted = alone.size + (base != ALONE)
        yield replace(whole, free_nodes=whole.size - wanted)


def _built(base: Sum, argument: Sum | None, build: Callable[..., Sum], *values: float) -> Sum:
    """Return a base times a function with these numbers."""
    return _times(base, argument, build(*values))


def _times(base: Sum, argument: Sum | None, factor: Sum) -> Sum:
    return mul(base, factor if argument is None else substituted(factor, {0: argument}))
