"""Gravity on an angle, and what comes twice a turn."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ...operators import BUILTIN
from ...terms import Sum, call, constant, mul, variable
from ..given.design import Design
from ..given.ranges import Ranges
from .angles import bends, units_of
from .candidate import OFFSET, Candidate, CandidateMaker
from .names import GRAVITY, HARMONIC


def weights(
    effect: CandidateMaker, design: Design, position: int, ranges: Ranges
) -> Iterator[Candidate]:
    """Yield gravity on an angle, with an arbitrary zero if it swings far."""
    swing = ranges.swing_of(position)
    for unit in units_of(design, position, ranges):
        angle = mul(constant(unit), variable(position))
        across, along = call(BUILTIN["sin"], angle), call(BUILTIN["cos"], angle)
        yield effect(GRAVITY, across)
        yield effect(GRAVITY, along, parents=(OFFSET,), contains_parents=True)
        if bends(swing, unit):  # at small angles both together are any soft or hard spring
            yield effect(GRAVITY, across, along, parents=(OFFSET,), contains_parents=True)
        if swing * unit > np.pi / 2.0:  # on less than a whole period it is any curve
            yield from _second_harmonics(effect, mul(constant(2.0), angle))


def _second_harmonics(effect: CandidateMaker, twice: Sum) -> Iterator[Candidate]:
    """Yield what comes twice a turn: salient poles, a gradient of gravity, wind on a hull."""
    across, along = call(BUILTIN["sin"], twice), call(BUILTIN["cos"], twice)
    yield effect(HARMONIC, across)
    yield effect(HARMONIC, along, parents=(OFFSET,), contains_parents=True)
    yield effect(HARMONIC, across, along, parents=(OFFSET,), contains_parents=True)
