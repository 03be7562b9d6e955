"""What begins at a level of a first-order state: an overflow, a hole in a wall, a harmful dose.

Such a kink bends as many other terms do, so it has no place among the names. It is held against
what grows, with its level tuned on the same pieces.
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
from ..effects.stops import LEAST, PLACES, is_stop, stops
from ..evidence.scoring import sharpened
from ..given.design import Design
from ..given.segments import Segments

__all__ = ["begun_at_levels"]

READ = 9  # nodes of max(h - c, 0)^(3/2) as it is read, with a number in it


def begun_at_levels(design: Design, state: int, part: Segments) -> list[Candidate]:
    """Return what begins at a level and explains most of what an equation leaves.

    Parameters
    ----------
    design : Design
        The model so far.
    state : int
        Equation in question. That of a velocity has the stops of its position among the names.
    part : Segments
        Pieces to tune the levels on.

    Returns
    -------
    list of Candidate
        Dead zones with one end, and flows through holes; none if the state is a velocity, or where
        no level explains anything.
    """
    if design.position_of(state) is not None:
        return []
    ranges = part.ranges
    largest, middle = float(ranges.largest[state]), float(ranges.middle[state])
    seen = CandidateMaker(state), variable(state), largest, middle
    found: list[Candidate] = []
    for family in (filter(is_stop, stops(*seen)), *_flows(*seen)):
        # A level is where it is: no offset beside it where the state has a zero of its own.
        grid = [one if ranges.signed[state] else replace(one, parents=()) for one in family]
        found += sharpened(design, part, grid)[len(grid) :]
    return found


def _flows(
    effect: CandidateMaker, h: Sum, largest: float, middle: float
) -> Iterator[list[Candidate]]:
    """Go through what flows through a hole or over a weir, as a root of the head or its cube."""
    half = largest - abs(middle)
    places = [middle + share * half for share in PLACES]
    for power in (1, 3):
        yield [
            _at_level(effect, h, place, power, side)
            for place in places
            if abs(place) >= LEAST * largest
            for side in (-1, 1)
        ]


def _at_level(effect: CandidateMaker, h: Sum, place: float, power: int, side: int) -> Candidate:
    build = partial(_flow, h, power, side, np.sign(place))
    shape = Shape((abs(place),), (build,), branch=side)
    flow = effect(EVOLVED, shape=shape, parents=(OFFSET,))
    return replace(flow, free_nodes=flow.size - READ)


def _flow(h: Sum, power: int, side: int, toward: float, level: float) -> Sum:
    """Return the root of how far h is above a level (side 1) or below it (side -1), or its cube."""
    head = mul(constant(side), sub(h, constant(toward * level)))
    root = call(BUILTIN["sqrt"], call(BUILTIN["abs"], head))
    is_beyond = mul(constant(0.5), add(constant(1.0), call(BUILTIN["sgn"], head)))
    return mul(is_beyond, root if power == 1 else mul(head, root))
