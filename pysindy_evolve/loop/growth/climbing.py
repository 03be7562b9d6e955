"""Better a grown term by exchanging one factor at a time, its numbers tuned each time.

A random change of w sin(1.7 q) to w^2 sin(1.7 q) does worse, so the search drops it before the rate
is tuned to the 2 that makes it the right one. Here all terms that differ in one factor are looked
at, and the numbers of the most promising are tuned before they are compared.
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
from ..evidence.scoring import MARGIN, PRICE, net, score, tuned
from ..given.design import Design
from ..given.segments import Segments
from .naming import sparing
from .seeds import functions

__all__ = ["climbed", "with_best_numbers"]

N_TUNED = 6  # of the terms around one
SLOPE = 1e-3  # of a logarithm, to see what it changes
MOST_FACTORS = 3  # different ones: more are a fit of something else
MAX_STEPS = 4  # from where a search ended, the right term is seldom far


def climbed(
    begin: Candidate,
    design: Design,
    part: Segments,
    operators: Sequence[Operator],
    declared: Sequence[Product] = (),
) -> Candidate:
    """Return a term that no exchange of one factor betters any more.

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
        Terms of its equation, of which one that is held whole counts as one node.

    Returns
    -------
    Candidate
        The same one if nothing around it gains more than the price of its nodes.
    """
    factors = functions(operators, part.rows[:, :-1])
    best = _best(design, part, [begin], declared)
    for _ in range(MAX_STEPS):
        if best is None:  # not to be told from what the model holds
            return begin
        around = [_moved(begin, term, declared) for term in _around(best.group[0], factors)]
        other = _best(design, part, _promising(design, part, around), declared)
        if other is None or net(other) <= net(best) + MARGIN:
            break
        best = other
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
    tuned_ones = _tuned(design, part, _promising(design, part, candidates), declared)
    return [term for one in tuned_ones for _, term in one.terms[0].parts]


def _moved(candidate: Candidate, term: Product, declared: Sequence[Product]) -> Candidate:
    """Return a candidate with another term in its place; one that was tuned may spare no more."""
    terms, spared = (of_term(term),), sparing(term, declared)
    return replace(candidate, terms=terms, shape=None, free_nodes=spared)


def _promising(design: Design, part: Segments, around: Sequence[Candidate]) -> list[Candidate]:
    """Return the terms that gain most beside their slopes in the logarithms of their numbers.

    To first order that is what they gain once their numbers are tuned.
    """
    free = {_with_slopes(candidate): candidate for candidate in around}
    scores = score(design, part, list(free), pairs=False)
    gains = {free[s.group[0]]: s.value - PRICE * free[s.group[0]].size for s in scores}
    return sorted(gains, key=lambda candidate: -gains[candidate])[:N_TUNED]


def _with_slopes(candidate: Candidate) -> Candidate:
    shape = shape_of(candidate)
    if shape is None:
        return candidate
    steps = np.array(shape.values) * np.exp(SLOPE * np.eye(len(shape.values)))
    moved = (replace(shape, values=tuple(row.tolist())).terms[0] for row in steps)
    slopes = (mul(constant(1.0 / SLOPE), sub(there, candidate.terms[0])) for there in moved)
    return replace(candidate, terms=(*candidate.terms, *slopes))


def _best(
    design: Design, part: Segments, candidates: Sequence[Candidate], declared: Sequence[Product]
) -> Score | None:
    """Return the score of the best candidate, numbers tuned; None if none can be told apart."""
    plain = _tuned(design, part, candidates, declared)
    return max(score(design, part, plain, pairs=False), key=net, default=None)


def _tuned(
    design: Design, part: Segments, candidates: Sequence[Candidate], declared: Sequence[Product]
) -> list[Candidate]:
    sharp = (tuned(replace(c, shape=shape_of(c)), design, part) for c in candidates)
    return [_moved(c, term, declared) for c in sharp for _, term in c.terms[0].parts]


def _around(candidate: Candidate, factors: Sequence[Sum]) -> list[Product]:
    """Return the terms that differ from one in a factor: another one, one more or one less."""
    (term,) = (product for _, product in candidate.terms[0].parts)
    rests = [term, *_with_one_less(term)]
    products = (mul(of_term(rest), f) for rest in rests for f in (of_term(ONE), *factors))
    found = dict.fromkeys(p for product in products for _, p in product.parts)
    return [one for one in found if 0 < len(one.factors) <= MOST_FACTORS and one != term]


def _with_one_less(term: Product) -> Iterator[Product]:
    for place, (atom, n) in enumerate(term.factors):
        lower = ((atom, n - 1),) if n > 1 else ()
        yield Product((*term.factors[:place], *lower, *term.factors[place + 1 :]))
