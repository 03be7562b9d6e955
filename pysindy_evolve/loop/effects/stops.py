"""What begins at one place: an end stop, a contact, a rope that goes slack.

Each is a spring, in proportion to how far something lies beyond the place.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial

from ...reading.extremes import EXTREMES
from ...terms import Call, Product, Sum, constant, mul, sub
from .candidate import OFFSET, Candidate, CandidateMaker, Shape, rewritten

__all__ = ["begun_at_same", "stops"]

PLACES = (-0.6, -0.2, 0.2, 0.6)  # of half the range, from its middle
LEAST = 0.02  # of the largest magnitude: nearer to zero it is a magnitude, as |q|


def stops(effect: CandidateMaker, q: Sum, largest: float, middle: float) -> Iterator[Candidate]:
    """Go through what a state does beyond places in its range, on either side of each.

    Parameters
    ----------
    effect : CandidateMaker
        Makes candidates of the equation.
    q : Sum
        The state.
    largest : float
        Its largest magnitude.
    middle : float
        Halfway between its smallest and its largest value.

    Yields
    ------
    Candidate
        A dead zone that ends at one place. It has a mean, as an offset has.
    """
    half = largest - abs(middle)
    for place in (middle + share * half for share in PLACES):
        if abs(place) >= LEAST * largest:
            yield from _on_both_sides(effect, q, place)


def begun_at_same(candidate: Candidate) -> list[Candidate]:
    """Return the dead zones with one end that begin where an effect has its kink.

    Beside a spring and an offset all are one force: max(q, 0) is q + max(-q, 0), and (q + |q|) / 2.
    A dead zone with one end has one to the other side; a grown |q - c| has one to each.
    """
    if candidate.name == "dead zone" and candidate.whole and candidate.shape is not None:
        return [rewritten(candidate, _to_the_other_side)]
    kink = _kink_of(candidate.terms)
    if kink is None:
        return []
    return list(_on_both_sides(CandidateMaker(candidate.state), *kink))


def _on_both_sides(effect: CandidateMaker, q: Sum, place: float) -> Iterator[Candidate]:
    toward = 1 if place > 0.0 else -1
    for side in (1.0, -1.0):
        build = partial(_beyond, q, side, toward)
        shape = Shape((abs(place),), (build,), meanings=("end",), branch=toward)
        yield effect("dead zone", shape=shape, parents=(OFFSET,), whole=True)


def _kink_of(terms: Sequence[Sum]) -> tuple[Sum, float] | None:
    """Return the variable and the place of |q - c|; None of anything else."""
    factors = [factor for term in terms for _, part in term.parts for factor in part.factors]
    atom, exponent = factors[0] if len(factors) == 1 else (None, 0)
    if not isinstance(atom, Call) or atom.operator.name != "abs" or exponent != 1:
        return None
    (inner,) = atom.args
    place = -sum(c for c, part in inner.parts if not part.factors)
    rest = [(c, part) for c, part in inner.parts if part.factors]
    if place == 0.0 or len(rest) != 1 or rest[0][0] != 1.0 or rest[0][1].size != 1:
        return None
    return Sum(tuple(rest)), place


def _beyond(q: Sum, side: float, toward: int, end: float) -> Sum:
    """Return how far q lies above an end (side 1) or below it (side -1), toward a sign of q."""
    past = mul(constant(side), sub(q, constant(toward * end)))
    return EXTREMES["max"](past, constant(0.0))


def _to_the_other_side(expression: Sum) -> Sum:
    """Return (|a| - a) / 2 of (|a| + a) / 2: all but the magnitude changes its sign."""
    parts = expression.parts
    return Sum(tuple((c if _is_magnitude(term) else -c, term) for c, term in parts))


def _is_magnitude(term: Product) -> bool:
    return any(isinstance(atom, Call) for atom, _ in term.factors)
