"""Terms that begin at a level of a first-order state: an overflow, a hole, a harmful dose.

Many other terms bend like such a kink, so it is not in the vocabulary. It competes with grown
terms, and its level is tuned on the same pieces as they are.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial

import numpy as np

from ...operators import BUILTIN
from ...terms import Sum, add, call, constant, mul, sub, variable
from ..effects.candidate import OFFSET, Candidate, CandidateMaker, Shape
from ..effects.names import EVOLVED
from ..effects.stops import MIN_DISTANCE_SHARE, PLACES, is_stop, stops
from ..evidence.scoring import sharpened
from ..given.design import Design
from ..given.segments import Segments

READ = 9  # nodes that a flow counts as: max(h - c, 0)^(3/2) with its number


def terms_from_levels(design: Design, state: int, part: Segments) -> list[Candidate]:
    """Return the terms that begin at a level and explain most of the residual of an equation.

    Parameters
    ----------
    design : Design
        The model so far.
    state : int
        The equation. For a velocity, the vocabulary has the stops of its position instead.
    part : Segments
        Pieces to tune the levels on.

    Returns
    -------
    list of Candidate
        Dead zones with one end, and flows through holes; empty for a velocity, or if no level
        explains anything.
    """
    if design.position_of(state) is not None:
        return []
    ranges = part.ranges
    largest, middle = float(ranges.largest[state]), float(ranges.middle[state])
    arguments = CandidateMaker(state), variable(state), largest, middle
    found: list[Candidate] = []
    for family in (filter(is_stop, stops(*arguments)), *_flows(*arguments)):
        # A state that keeps its sign has a true zero, so its level needs no offset beside it.
        grid = [one if ranges.signed[state] else replace(one, parents=()) for one in family]
        found += sharpened(design, part, grid)[len(grid) :]
    return found


def _flows(
    effect: CandidateMaker, h: Sum, largest: float, middle: float
) -> Iterator[list[Candidate]]:
    """Yield flows through a hole or over a weir: head^(1/2), then head^(3/2)."""
    half = largest - abs(middle)
    places = [middle + share * half for share in PLACES]
    for power in (1, 3):
        yield [
            _at_level(effect, h, place, power, side)
            for place in places
            if abs(place) >= MIN_DISTANCE_SHARE * largest
            for side in (-1, 1)
        ]


def _at_level(effect: CandidateMaker, h: Sum, place: float, power: int, side: int) -> Candidate:
    build = partial(_flow, h, power, side, np.sign(place))
    shape = Shape((abs(place),), (build,), branch=side)
    flow = effect(EVOLVED, shape=shape, parents=(OFFSET,))
    return replace(flow, free_nodes=flow.size - READ)


def _flow(h: Sum, power: int, side: int, sign: float, level: float) -> Sum:
    """Return sqrt(head)^power of the head above a level (side 1) or below it (side -1)."""
    head = mul(constant(side), sub(h, constant(sign * level)))
    root = call(BUILTIN["sqrt"], call(BUILTIN["abs"], head))
    is_beyond = mul(constant(0.5), add(constant(1.0), call(BUILTIN["sgn"], head)))
    return mul(is_beyond, root if power == 1 else mul(head, root))
