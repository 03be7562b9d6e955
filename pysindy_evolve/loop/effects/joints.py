"""Forces at the joints of an arm, which enter through its inverse mass matrix.

Likewise what flows into a chamber changes its pressure the less, the larger the chamber is by now.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial

from ...terms import mul, variable
from ..given.design import Design
from ..given.ranges import Ranges
from .angles import centripetal
from .candidate import OFFSET, Candidate, CandidateMaker, bare, rewritten
from .differences import differences
from .entries import Entry
from .frictions import frictions
from .names import CONSTANT_OFFSET
from .springs import springs


def at_joints(
    effect: CandidateMaker,
    design: Design,
    entries: Sequence[Entry],
    ranges: Ranges,
    turning: frozenset[int],
) -> Iterator[Candidate]:
    """Yield forces that enter where a declared force does, with a factor that is not constant."""
    for entry in entries:
        forces = [effect(CONSTANT_OFFSET, OFFSET), *centripetal(effect, design, turning)]
        for v in entry.velocities:
            forces += frictions(effect, variable(v), float(ranges.largest[v]))
            q = design.position_of(v)
            if q is not None:
                forces += springs(effect, variable(q), float(ranges.largest[q]))
        if design.position_of(effect.state) is None:
            forces += _flows(effect, design, ranges)
        # Without its sign, the factor -q^2 of a damping makes a spring q the cubic stiffness, which
        # has its name already.
        is_free = len(entry.factor.parts) == 1 and not entry.is_known
        factor = bare(entry.factor) if is_free else entry.factor
        for force in forces:
            entering = rewritten(force, partial(mul, factor))
            yield replace(entering, never_paired=True, acts_at=((entry.beside,), force.terms))


def _flows(effect: CandidateMaker, design: Design, ranges: Ranges) -> Iterator[Candidate]:
    """Yield what a first-order state and its differences to others drive, such as a leak."""
    state = effect.state
    yield from frictions(effect, variable(state), float(ranges.largest[state]))
    for other in range(len(design.states)):
        if other != state:
            yield from differences(effect, design, state, other, ranges)
