"""What other states do to an equation: couplings, and forces of a relative motion."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations

from ...terms import mul, power, sub, variable
from ..given.design import Design
from ..given.ranges import Ranges
from .candidate import OFFSET, Candidate, CandidateMaker
from .differences import acting_differences
from .frictions import slips
from .names import COUPLING
from .springs import stretches


def couplings(effect: CandidateMaker, state: int, other: int) -> Iterator[Candidate]:
    """Yield what one other state does, alone, times the own one, or squared."""
    own, w = variable(state), variable(other)
    yield effect(COUPLING, w)
    yield effect(COUPLING, mul(own, w), parents=(OFFSET,))
    yield effect(COUPLING, power(w, 2), parents=(OFFSET,))


def products_of_others(
    effect: CandidateMaker, design: Design, own: set[int | None]
) -> Iterator[Candidate]:
    """Yield products of two other states: a reaction, a gyroscopic moment."""
    others = set(range(len(design.states))) - own
    rates = [s for s in sorted(others) if design.derivative_of(s) is None]
    for one, other in combinations(rates, 2):
        yield effect(COUPLING, mul(variable(one), variable(other)), parents=(OFFSET,))


def between(
    effect: CandidateMaker, design: Design, state: int, other: int, ranges: Ranges
) -> Iterator[Candidate]:
    """Yield the forces between two bodies, which depend on their relative motion."""
    position = design.position_of(state)
    if position is None:
        return
    if design.position_of(other) is not None:
        slip = sub(variable(state), variable(other))
        yield from slips(effect, slip, float(ranges.apart[state, other]))
    if design.derivative_of(other) is not None:
        stretch = sub(variable(position), variable(other))
        yield from stretches(effect, stretch, float(ranges.apart[position, other]))


def relative(
    effect: CandidateMaker, design: Design, state: int, ranges: Ranges
) -> Iterator[Candidate]:
    """Yield the forces of a motion relative to an input: to the wind, or to a shaken floor."""
    for own, other in acting_differences(design, state):
        motion = sub(variable(own), variable(other))
        if own == state:
            yield from slips(effect, motion, float(ranges.apart[own, other]))
        else:
            yield from stretches(effect, motion, float(ranges.apart[own, other]))
