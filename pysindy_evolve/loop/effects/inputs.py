"""What an input does to an equation: gains, nonlinearities, saturations."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from ...terms import Sum, mul, power
from .candidate import OFFSET, Candidate, CandidateMaker, Shape
from .kinks import clipped, magnitude
from .names import INPUT_GAIN, INPUT_NONLINEARITY, SATURATION
from .stops import asymmetric_limits

__all__ = ["of_input"]

SATURATIONS = (0.08, 0.2, 0.35, 0.5, 0.7, 0.9)  # limits, as shares of the reach


def of_input(
    effect: CandidateMaker, u: Sum, own: list[Sum], reach: float, middle: float
) -> Iterator[Candidate]:
    """Yield effects of an input, alone and times the own states."""
    yield effect(INPUT_GAIN, u)
    for x in own:
        yield effect(INPUT_GAIN, mul(u, x), parents=(OFFSET,))
    yield effect(INPUT_NONLINEARITY, power(u, 2), parents=(OFFSET,))
    yield effect(INPUT_NONLINEARITY, mul(u, magnitude(u)))
    yield effect(INPUT_NONLINEARITY, power(u, 3))
    for share in SATURATIONS:
        shape = Shape((share * reach,), (partial(clipped, u),), meanings=("limit",))
        yield effect(SATURATION, shape=shape)
    yield from asymmetric_limits(effect, u, reach, middle)
