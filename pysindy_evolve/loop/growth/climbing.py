"""Improve a grown term by exchanging one factor at a time, its numbers tuned each time.

If w^2 sin(2 q) is missing, a random change of w sin(1.7 q) to w^2 sin(1.7 q) fits worse, so the
search drops it before its number is tuned to 2. Here all terms that differ in one factor are
scored, and the numbers of the most promising ones are tuned before they are compared.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from ...operators import Operator
from ...terms import ONE, Product, Sum, constant, mul, of_term, sub
from ..effects.candidate import Candidate
from ..effects.shaping import shape_of
from ..evidence.ranking import Score
from ..evidence.scoring import MIN_GAIN_LOG, PRICE_PER_NODE_LOG, net, score, tuned
from ..given.design import Design
from ..given.segments import Segments
from .curves import curves
from .naming import nodes_saved
from .seeds import functions

N_TUNED = 6  # most promising terms, whose numbers are tuned
STEP_IN_LOG = 1e-3  # step in the logarithm of a number, to take its derivative
MOST_FACTORS = 3  # distinct factors of a term: with more it fits something else
MAX_STEPS = 4  # exchanges: the right term is seldom farther from where a search ended


def climbed(
    begin: Candidate,
    design: Design,
    part: Segments,
    operators: Sequence[Operator],
    declared: Sequence[Product] = (),
) -> Candidate:
    """Return a term that no exchange of one factor improves any further.

    Parameters
    ----------
    begin : Candidate
        A grown term.
    design : Design
        The model so far.
    part : Segments
        Pieces to search in.
    operators : sequence of Operator
        Basis functions.
    declared : sequence of Product
        Terms of its equation; one that a grown term contains whole counts as one node.

    Returns
    -------
    Candidate
        `begin` with its numbers tuned, if no neighbor gains clearly more after the price of nodes.
    """
    variables = part.rows[:, :-1]
    factors = [*functions(operators, variables), *curves(operators, variables, len(design.states))]
    best = _best(design, part, [begin], declared)
    for _ in range(MAX_STEPS):
        if best is None:  # a combination of the model's columns
            return begin
        neighbors = [
            _with_term(begin, term, declared) for term in _neighbors(best.group[0], factors)
        ]
        neighbor = _best(design, part, _promising(design, part, neighbors), declared)
        if neighbor is None or net(neighbor) <= net(best) + MIN_GAIN_LOG:
            break
        best = neighbor
    return best.group[0] if best else begin


def with_best_numbers(
    candidates: Sequence[Candidate],
    design: Design,
    part: Segments,
    declared: Sequence[Product] = (),
) -> list[Product]:
    """Return the terms that gain most once their numbers are tuned, with these numbers.

    Parameters
    ----------
    candidates : sequence of Candidate
        Grown terms, one in each.
    design : Design
        The model so far.
    part : Segments
        Pieces to search in.
    declared : sequence of Product
        As in `climbed`.

    Returns
    -------
    list of Product
    """
    best = _tuned(design, part, _promising(design, part, candidates), declared)
    return [term for candidate in best for _, term in candidate.terms[0].parts]


def _with_term(candidate: Candidate, term: Product, declared: Sequence[Product]) -> Candidate:
    """Return a candidate with another term; its free nodes are counted again after tuning."""
    terms, free_nodes = (of_term(term),), nodes_saved(term, declared)
    return replace(candidate, terms=terms, shape=None, free_nodes=free_nodes)


def _promising(design: Design, part: Segments, candidates: Sequence[Candidate]) -> list[Candidate]:
    """Return the terms that gain most together with their slopes in log(number).

    To first order this is their gain after tuning.
    """
    originals = {_with_slopes(candidate): candidate for candidate in candidates}
    scores = score(design, part, list(originals), pairs=False)
    gains = {
        originals[s.group[0]]: s.value - PRICE_PER_NODE_LOG * originals[s.group[0]].size
        for s in scores
    }
    return sorted(gains, key=lambda candidate: -gains[candidate])[:N_TUNED]


def _with_slopes(candidate: Candidate) -> Candidate:
    shape = shape_of(candidate)
    if shape is None:
        return candidate
    steps = np.array(shape.values) * np.exp(STEP_IN_LOG * np.eye(len(shape.values)))
    shifted_terms = (replace(shape, values=tuple(row.tolist())).terms[0] for row in steps)
    slopes = (
        mul(constant(1.0 / STEP_IN_LOG), sub(shifted, candidate.terms[0]))
        for shifted in shifted_terms
    )
    return replace(candidate, terms=(*candidate.terms, *slopes))


def _best(
    design: Design, part: Segments, candidates: Sequence[Candidate], declared: Sequence[Product]
) -> Score | None:
    """Return the best score after tuning; None if all are combinations of the model's columns."""
    plain = _tuned(design, part, candidates, declared)
    return max(score(design, part, plain, pairs=False), key=net, default=None)


def _tuned(
    design: Design, part: Segments, candidates: Sequence[Candidate], declared: Sequence[Product]
) -> list[Candidate]:
    tuned_candidates = (tuned(replace(c, shape=shape_of(c)), design, part) for c in candidates)
    return [_with_term(c, term, declared) for c in tuned_candidates for _, term in c.terms[0].parts]


def _neighbors(candidate: Candidate, factors: Sequence[Sum]) -> list[Product]:
    """Return the terms with one factor exchanged, added or removed."""
    (term,) = (product for _, product in candidate.terms[0].parts)
    bases = [term, *_without_a_factor(term)]
    products = (mul(of_term(base), f) for base in bases for f in (of_term(ONE), *factors))
    found = dict.fromkeys(p for product in products for _, p in product.parts)
    return [
        neighbor
        for neighbor in found
        if 0 < len(neighbor.factors) <= MOST_FACTORS and neighbor != term
    ]


def _without_a_factor(term: Product) -> Iterator[Product]:
    for place, (atom, n) in enumerate(term.factors):
        lower = ((atom, n - 1),) if n > 1 else ()
        yield Product((*term.factors[:place], *lower, *term.factors[place + 1 :]))
