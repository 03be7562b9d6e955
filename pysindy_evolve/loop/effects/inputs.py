"""What an input does to an equation: gains, nonlinearities, saturations."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial

from ...terms import Sum, Variable, mul, of_term, power, variable
from ..given.design import Design
from ..given.ranges import Ranges
from .candidate import OFFSET, Candidate, CandidateMaker, Shape, rewritten
from .kinks import clipped, magnitude
from .names import INPUT_GAIN, INPUT_NONLINEARITY, SATURATION
from .stops import asymmetric_limits
from .varying_terms import parts_of

SATURATIONS = (0.08, 0.2, 0.35, 0.5, 0.7, 0.9)  # limits, as shares of the largest magnitude


def of_input(
    effect: CandidateMaker, column: int, own: list[Sum], ranges: Ranges
) -> Iterator[Candidate]:
    """Yield effects of an input, alone and times the own states."""
    u, largest = variable(column), float(ranges.largest[column])
    yield effect(INPUT_GAIN, u)
    for x in own:
        yield effect(INPUT_GAIN, mul(u, x), parents=(OFFSET,))
    yield effect(INPUT_NONLINEARITY, power(u, 2), parents=(OFFSET,))
    yield effect(INPUT_NONLINEARITY, mul(u, magnitude(u)))
    yield effect(INPUT_NONLINEARITY, power(u, 3))
    yield from _saturations(effect, u, largest)
    yield from asymmetric_limits(effect, u, largest, float(ranges.middle[column]))


def within_terms(
    effect: CandidateMaker, design: Design, column: int, ranges: Ranges
) -> Iterator[Candidate]:
    """Yield an input that saturates, or has a dead zone, within a declared term.

    A valve lets pass its opening times a root of the pressures, and nothing near its middle.
    """
    u, largest = variable(column), float(ranges.largest[column])
    for rest in _beside(design, effect.state, column):
        for clip in _saturations(effect, u, largest):
            within = rewritten(clip, partial(mul, rest))
            yield replace(within, never_paired=True, acts_at=((column,), clip.terms))


def clipped_input(saturation: Candidate) -> int:
    """Return the input that a saturation clips, which may stand within a term."""
    if saturation.acts_at is not None:
        ((column,), _) = saturation.acts_at
        return column
    (column,) = saturation.variables
    return column


def _saturations(effect: CandidateMaker, u: Sum, largest: float) -> Iterator[Candidate]:
    for share in SATURATIONS:
        shape = Shape((share * largest,), (partial(clipped, u),), meanings=("limit",))
        yield effect(SATURATION, shape=shape)


def _beside(design: Design, state: int, column: int) -> Iterator[Sum]:
    """Yield what stands beside an input, as its factor, in the terms of an equation."""
    for term in (part.parts[0][1] for part in parts_of(design, state) if len(part.parts) == 1):
        for place, factor in enumerate(term.factors):
            rest = of_term(term.without(place))
            if factor == (Variable(column), 1) and rest.variables:
                yield rest
