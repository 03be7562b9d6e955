"""Forces along or against a motion in a plane or in space: of shafts, and of balls in flight.

The drag on one coordinate depends on the speed, and thereby on all others.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import reduce

from ...operators import BUILTIN
from ...terms import Sum, add, call, mul, power, variable
from ..given.design import Design
from .candidate import Candidate, CandidateMaker
from .names import CUBIC_STIFFNESS, QUADRATIC_DRAG


def radial(effect: CandidateMaker, design: Design, turning: frozenset[int]) -> Iterator[Candidate]:
    """Yield forces on one velocity along a motion: in a plane with each other one, or in space.

    Angles (`turning`) are no coordinates of a plane.
    """
    flat = [v for v in design.velocities if design.position_of(v) not in turning]
    if effect.state not in flat:
        return
    others = [v for v in flat if v != effect.state]
    pairs = [[effect.state, other] for other in others]
    for moving in [*pairs, flat] if len(others) > 1 else pairs:
        places = [p for p in map(design.position_of, moving) if p is not None]
        speed = call(BUILTIN["sqrt"], _squares(moving))
        yield effect(QUADRATIC_DRAG, mul(variable(effect.state), speed))
        yield effect(CUBIC_STIFFNESS, mul(variable(places[0]), _squares(places)))


def _squares(indices: Sequence[int]) -> Sum:
    return reduce(add, (power(variable(index), 2) for index in indices))
