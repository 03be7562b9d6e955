"""Springs that begin at a place: an end stop, a contact, a slack rope; or a stop at either end.

Their force is in proportion to how far something lies beyond the place.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial, reduce

import numpy as np

from ...operators import BUILTIN
from ...reading.extremes import EXTREMES
from ...terms import Call, Product, Sum, add, call, constant, mul, power, sub
from ..given.design import Design
from .candidate import OFFSET, Candidate, CandidateMaker, Shape, rewritten
from .names import ASYMMETRIC_STIFFNESS, DEAD_ZONE, NONLINEAR_DAMPING, SATURATION
from .varying_terms import parts_of

PLACES = (-0.6, -0.2, 0.2, 0.6)  # of stops, as shares of half the range from its middle
ENDS = (0.75, 0.9)  # the same near the ends, where most of the motion is free
WIDTHS = (0.3, 0.7)  # between two stops, as shares of the range
SIGNS = {2: (-1, 1), 4: (1, 1), -4: (-1, -1)}  # of a lower and an upper end, by branch
# Distance of a place from zero, over the largest magnitude; below it is |q|.
MIN_DISTANCE_SHARE = 0.02


def stops(effect: CandidateMaker, q: Sum, largest: float, middle: float) -> Iterator[Candidate]:
    """Yield springs of a state beyond a place in its range, on either side, and beyond two places.

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
        A dead zone that ends at one place, or at two with a stiffness each. It has a mean, so an
        offset is its parent.
    """
    half, least = largest - abs(middle), MIN_DISTANCE_SHARE * largest
    for place in (middle + share * half for share in PLACES):
        if abs(place) >= least:
            yield from (_at(effect, q, place, side) for side in (1.0, -1.0))
    yield from _between_ends(effect, DEAD_ZONE, q, largest, middle)


def end_stops(effect: CandidateMaker, q: Sum, largest: float, middle: float) -> Iterator[Candidate]:
    """Yield stops near the ends of the range of a state, as in `stops`."""
    half, least = largest - abs(middle), MIN_DISTANCE_SHARE * largest
    for place, side in ((middle + s * share * half, s) for share in ENDS for s in (1.0, -1.0)):
        if abs(place) >= least:
            yield _at(effect, q, place, side)


def asymmetric_limits(
    effect: CandidateMaker, u: Sum, largest: float, middle: float
) -> Iterator[Candidate]:
    """Yield limits, or dead zones, of an input with two ends and another slope beyond each."""
    yield from _between_ends(effect, SATURATION, u, largest, middle)


def ends_of(shape: Shape) -> tuple[float, float]:
    """Return where a limit or a dead zone of two sides begins below and above.

    Its shape holds a half width, or two ends.
    """
    if len(shape.values) == 1:
        (width,) = shape.values
        return -width, width
    (below, above), (low, high) = SIGNS[shape.branch], shape.values
    return below * low, above * high


def damped_contacts(effect: CandidateMaker, design: Design, q: Sum, v: Sum) -> Iterator[Candidate]:
    """Yield dampings of the contacts in an equation: in proportion to depth, or while closed.

    References
    ----------
    Hunt and Crossley, Coefficient of restitution interpreted as damping in vibroimpact, Journal of
    Applied Mechanics 42 (1975), 440-445: damping in proportion to the depth.
    """
    for part in parts_of(design, effect.state):
        if _begins_at_a_place(part, q):
            depth = mul(constant(0.5), part)  # of |q - c| + q - c
            yield effect(NONLINEAR_DAMPING, mul(v, depth))
            yield effect(NONLINEAR_DAMPING, mul(v, _closed(depth)))


def is_stop(candidate: Candidate) -> bool:
    """Tell whether an effect is a dead zone with one end."""
    contains_offset = (
        candidate.name == DEAD_ZONE and candidate.contains_parents and candidate.shape is not None
    )
    return contains_offset and len(candidate.terms) == 1


def pressed(stop: Candidate) -> Candidate:
    """Return an end stop whose force grows with depth^(3/2), as between curved bodies.

    References
    ----------
    Johnson, Contact Mechanics (1985), ISBN 978-0-521-34796-9, chapter 4: Hertz's depth^(3/2).
    """
    return rewritten(stop, _to_three_halves)


def has_two_ends(candidate: Candidate) -> bool:
    """Tell whether an effect begins at two places, with a slope beyond each."""
    return candidate.contains_parents and candidate.shape is not None and len(candidate.terms) == 2


def one_end_each(candidate: Candidate) -> list[Candidate]:
    """Return the stop at each end of a dead zone with two: a motion may meet only one of them."""
    if candidate.shape is None or candidate.name != DEAD_ZONE or not has_two_ends(candidate):
        return []
    effect, q = CandidateMaker(candidate.state), _travel_in(candidate.terms[0])
    return [_at(effect, q, *end) for end in zip(ends_of(candidate.shape), (-1.0, 1.0), strict=True)]


def kinked_at_zero(candidate: Candidate) -> Candidate | None:
    """Return another stiffness above zero, in the place of a dead zone with two ends.

    A crack that opens and closes looks like one with no width, of which no record says how stiff
    either side is. None in the place of any other effect.
    """
    if candidate.name != DEAD_ZONE or not has_two_ends(candidate):
        return None
    above = EXTREMES["max"](_travel_in(candidate.terms[0]), constant(0.0))
    return CandidateMaker(candidate.state)(ASYMMETRIC_STIFFNESS, above)


def begins_within(candidate: Candidate, variables: np.ndarray) -> bool:
    """Tell whether each end of a stop acts on some rows, and none on others.

    If not, an end is out of range, or the lower end is above the upper one: a straight line.
    """
    beyond = np.column_stack([term.evaluate(variables) for term in candidate.terms]) != 0.0
    return bool(beyond.any(axis=0).all() and not beyond.any(axis=1).all())


def begun_at_same(candidate: Candidate) -> list[Candidate]:
    """Return the stops that begin where an effect has its kink.

    Beside a spring and an offset all are one force: max(q, 0) is q + max(-q, 0), and (q + |q|) / 2.
    For a stop this is the one to the other side; for a grown |q - c|, one to each side.
    """
    if is_stop(candidate):
        return [rewritten(candidate, _to_the_other_side)]
    kink = _kink_of(candidate.terms)
    if kink is None:
        return []
    return [_at(CandidateMaker(candidate.state), *kink, side) for side in (1.0, -1.0)]


def _between_ends(
    effect: CandidateMaker, name: str, q: Sum, largest: float, middle: float
) -> Iterator[Candidate]:
    half = largest - abs(middle)
    for low, high in ((middle - share * half, middle + share * half) for share in WIDTHS):
        if min(abs(low), abs(high)) >= MIN_DISTANCE_SHARE * largest:
            yield effect(
                name, shape=_two_ends(q, low, high), parents=(OFFSET,), contains_parents=True
            )


def _two_ends(q: Sum, low: float, high: float) -> Shape:
    below, above = _sign_of(low), _sign_of(high)
    builds = (partial(_above, q, above), partial(_below, q, below))
    (branch,) = (number for number, signs in SIGNS.items() if signs == (below, above))
    meanings = (_meaning("lower end", below), _meaning("upper end", above))
    return Shape((abs(low), abs(high)), builds, meanings=meanings, branch=branch)


def _meaning(end: str, sign: int) -> str:
    return end if sign > 0 else f"{end}, below zero"  # numbers of shapes are positive


def _sign_of(place: float) -> int:
    return 1 if place > 0.0 else -1


def _above(q: Sum, sign: int, low: float, high: float) -> Sum:
    return _beyond(q, 1.0, sign, high)


def _below(q: Sum, sign: int, low: float, high: float) -> Sum:
    return _beyond(q, -1.0, sign, low)


def _at(effect: CandidateMaker, q: Sum, place: float, side: float) -> Candidate:
    """Return a dead zone that ends at a place, with a spring above it (side 1) or below."""
    sign = _sign_of(place)
    build = partial(_beyond, q, side, sign)
    shape = Shape((abs(place),), (build,), meanings=(_meaning("end", sign),), branch=sign)
    return effect(DEAD_ZONE, shape=shape, parents=(OFFSET,), contains_parents=True)


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


def _travel_in(beyond: Sum) -> Sum:
    """Return q of (q - c + |q - c|) / 2, a position or a stretch between two."""
    straight = [(c, part) for c, part in beyond.parts if part.factors and not _is_magnitude(part)]
    return Sum(tuple((2.0 * c, part) for c, part in straight))


def _beyond(q: Sum, side: float, sign: int, end: float) -> Sum:
    """Return how far q lies above an end (side 1) or below it (side -1), of the given sign."""
    past = mul(constant(side), sub(q, constant(sign * end)))
    return EXTREMES["max"](past, constant(0.0))


def _begins_at_a_place(expression: Sum, q: Sum) -> bool:
    """Tell whether an expression is zero on one side of a place and straight beyond it."""
    if expression.variables != q.variables or len(expression.parts) != 3:
        return False
    return sum(_is_magnitude(term) for _, term in expression.parts) == 1


def _closed(depth: Sum) -> Sum:
    """Return 1 where a contact is closed and 0 elsewhere: the slope of its depth, made positive."""
    slopes = [_slope_of(coefficient, term) for coefficient, term in depth.parts if term.factors]
    slope = reduce(add, slopes)
    (outward,) = (c for c, term in depth.parts if term.factors and not _is_magnitude(term))
    return mul(constant(1.0 if outward > 0.0 else -1.0), slope)


def _slope_of(coefficient: float, term: Product) -> Sum:
    ((atom, _),) = term.factors
    if isinstance(atom, Call):
        return mul(constant(coefficient), call(BUILTIN["sgn"], *atom.args))
    return constant(coefficient)


def _to_the_other_side(expression: Sum) -> Sum:
    """Return (|a| - a) / 2 of (|a| + a) / 2: all but the magnitude changes its sign."""
    parts = expression.parts
    return Sum(tuple((c if _is_magnitude(term) else -c, term) for c, term in parts))


def _to_three_halves(depth: Sum) -> Sum:
    return power(call(BUILTIN["sqrt"], depth), 3)


def _is_magnitude(term: Product) -> bool:
    return any(isinstance(atom, Call) for atom, _ in term.factors)
