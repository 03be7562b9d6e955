"""What begins beyond a threshold: a stop on one side, a relief valve, a diode, a kidney's spill."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from ...operators import BUILTIN
from ...terms import Sum, add, call, constant, mul, sub, variable
from ..given.design import Design
from .candidate import OFFSET, Candidate, CandidateMaker, Shape, bare

__all__ = ["thresholds"]

PLACES = (0.1, 0.2, 0.3, 0.4, 0.6, 0.7, 0.8, 0.9)  # of thresholds, as shares of the range
MEANING = "distance of the threshold from zero"


def thresholds(
    effect: CandidateMaker, design: Design, own: int, scale: float, middle: float
) -> Iterator[Candidate]:
    """Go through what a state adds beyond a threshold, and what it adds below one.

    Where the state has a coefficient already, the two sides differ by what stands there, so only
    the side is offered that begins within the outer half of the range.

    Parameters
    ----------
    effect : CandidateMaker
        Makes candidates for the equation.
    design : Design
        The model so far.
    own : int
        The state.
    scale, middle : float
        Its largest magnitude, and halfway between its smallest and its largest value.
    """
    low = middle - (scale - abs(middle))
    width = 2.0 * (scale - abs(middle))
    columns = (column.parts[effect.state] for column in design.columns)
    has_slope = variable(own) in (bare(part) for part in columns if part.parts)
    for share in PLACES:
        place = low + share * width
        for side in (1.0, -1.0):
            if place and (not has_slope or side * (share - 0.5) > 0.0):
                sign = 1.0 if place > 0.0 else -1.0
                build = partial(_beyond, variable(own), side, sign)
                shape = Shape((abs(place),), (build,), meanings=(MEANING,))
                yield effect("threshold", shape=shape, parents=(OFFSET,), alone=True)


def _beyond(x: Sum, side: float, sign: float, size: float) -> Sum:
    """Return max(x - place, 0) on the upper side, min(x - place, 0) on the lower one."""
    over = sub(x, constant(sign * size))
    return mul(constant(0.5), add(over, mul(constant(side), call(BUILTIN["abs"], over))))
