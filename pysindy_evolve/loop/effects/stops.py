"""What begins at one place: an end stop, a contact, a rope that goes slack.

Each is a spring, in proportion to how far something lies beyond the place.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from ...reading.extremes import EXTREMES
from ...terms import Call, Product, Sum, constant, mul, sub
from .candidate import OFFSET, Candidate, CandidateMaker, Shape, rewritten

__all__ = ["mirrored", "stops"]

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
            toward = 1.0 if place > 0.0 else -1.0
            for side in (1.0, -1.0):
                shape = Shape(
                    (abs(place),), (partial(_beyond, q, side, toward),), meanings=("end",)
                )
                yield effect("dead zone", shape=shape, parents=(OFFSET,), whole=True)


def mirrored(candidate: Candidate) -> Candidate | None:
    """Return what begins at the same place to the other side; None of any other effect.

    Beside a spring and an offset both are one force: max(q, 0) is q + max(-q, 0).
    """
    if candidate.name != "dead zone" or not candidate.whole or candidate.shape is None:
        return None
    return rewritten(candidate, _to_the_other_side)


def _beyond(q: Sum, side: float, toward: float, end: float) -> Sum:
    """Return how far q lies above an end (side 1) or below it (side -1), toward a sign of q."""
    past = mul(constant(side), sub(q, constant(toward * end)))
    return EXTREMES["max"](past, constant(0.0))


def _to_the_other_side(expression: Sum) -> Sum:
    """Return (|a| - a) / 2 of (|a| + a) / 2: all but the magnitude changes its sign."""
    parts = expression.parts
    return Sum(tuple((c if _is_magnitude(term) else -c, term) for c, term in parts))


def _is_magnitude(term: Product) -> bool:
    return any(isinstance(atom, Call) for atom, _ in term.factors)
