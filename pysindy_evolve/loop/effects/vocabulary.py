"""The vocabulary: effects that engineers know by name, equation by equation, simple ones first.

Each effect is built in the file that its kind is named after. Squares, products, absolute values
and time have a mean, so each of them can pose as an offset. They may enter only where the constant
itself already stands (the marginality principle of regression, Nelder 1977, DOI 10.2307/2344517).
"""

from __future__ import annotations

from collections.abc import Iterator

from ...terms import Sum, variable
from ..given.design import Design
from ..given.ranges import Ranges
from .angles import angles_of, between_angles, centrifugal, centripetal
from .candidate import OFFSET, Candidate, CandidateMaker
from .couplings import between, couplings, products_of_others, relative
from .differences import differences, losses, radiated
from .entries import entries_of
from .frictions import frictions, frictions_by_position
from .hysteresis import remembering, rounded, yields
from .inputs import of_input, within_terms
from .joints import at_joints
from .links import link_couplings, link_weights
from .names import CONSTANT_OFFSET
from .radial_forces import radial
from .saturating_rates import saturating
from .slips import leveling
from .springs import springs
from .stops import damped_contacts, stops
from .valves import throttled
from .varying_terms import drifts, varying
from .weights import weights


def of_equation(design: Design, state: int, ranges: Ranges) -> Iterator[Candidate]:
    """Yield the vocabulary for one equation, simple effects before composed ones.

    A term of several effects, such as the square of a position, has the name of the first.
    """
    effect = CandidateMaker(state)
    if design.algebraic:
        found = _of_target(effect, design, ranges)
    else:
        found = _of_rate(effect, design, ranges)
    seen: set[tuple[Sum, ...]] = set()
    for candidate in found:
        if candidate.terms not in seen:
            seen.add(candidate.terms)
            yield candidate


def _of_rate(effect: CandidateMaker, design: Design, ranges: Ranges) -> Iterator[Candidate]:
    """Yield the effects in the rate of a state."""
    state, turning = effect.state, angles_of(design)
    position = design.position_of(state)
    yield effect(CONSTANT_OFFSET, OFFSET)
    yield from frictions(effect, variable(state), float(ranges.largest[state]))
    if position is not None:
        yield from _of_position(effect, design, position, turning, ranges)
    yield from _of_other_states(effect, design, position, turning, ranges)
    if position is None:
        yield from radiated(effect, design, ranges)
    yield from _of_inputs(effect, design, position, ranges)
    yield from relative(effect, design, state, ranges)
    yield from leveling(effect, design, ranges)
    yield from radial(effect, design, turning)
    entries = entries_of(design, state)
    yield from at_joints(effect, design, entries, ranges, turning)
    yield from link_weights(effect, design, entries, ranges, turning)
    yield from link_couplings(effect, design, entries, turning)
    yield from varying(effect, design)
    yield from saturating(effect, design, ranges)
    yield from throttled(effect, design, ranges)
    yield from drifts(effect, design, variable(design.time))


def _of_position(
    effect: CandidateMaker,
    design: Design,
    position: int,
    turning: frozenset[int],
    ranges: Ranges,
) -> Iterator[Candidate]:
    """Yield what the position of a velocity does to it."""
    q, v = variable(position), variable(effect.state)
    largest, middle = float(ranges.largest[position]), float(ranges.middle[position])
    yield from springs(effect, q, largest)
    yield from stops(effect, q, largest, middle)
    yield from damped_contacts(effect, design, q, v)
    yield from weights(effect, design, position, ranges)
    yield from frictions_by_position(effect, q, v)
    yield from centripetal(effect, design, turning)
    yield from centrifugal(effect, design, position, turning)


def _of_other_states(
    effect: CandidateMaker,
    design: Design,
    position: int | None,
    turning: frozenset[int],
    ranges: Ranges,
) -> Iterator[Candidate]:
    """Yield what states do that are neither the own one nor its position."""
    state = effect.state
    own = state if position is None else position
    for other in range(len(design.states)):
        if other not in (state, position):
            yield from couplings(effect, state, other)
            yield from differences(effect, design, state, other, ranges)
            yield from between(effect, design, state, other, ranges)
            if {own, other} <= turning:
                yield from between_angles(effect, variable(own), variable(other))
    yield from products_of_others(effect, design, {state, position})


def _of_inputs(
    effect: CandidateMaker, design: Design, position: int | None, ranges: Ranges
) -> Iterator[Candidate]:
    """Yield what the inputs do."""
    v = variable(effect.state)
    own = [v] if position is None else [v, variable(position)]
    for column in range(len(design.states), design.time):
        yield from of_input(effect, column, own, ranges)
        yield from within_terms(effect, design, column, ranges)
        if position is None:
            yield from losses(effect, design, column)


def _of_target(effect: CandidateMaker, design: Design, ranges: Ranges) -> Iterator[Candidate]:
    """Yield the effects in a target that is a function of inputs."""
    yield effect(CONSTANT_OFFSET, OFFSET)
    first = len(design.states)
    velocities = {v for _, v in design.motions}
    moving: set[int] = set()
    for x, v in design.motions:
        if x in velocities:  # velocity and acceleration
            yield from yields(effect, v, x, ranges, 0.0)  # the zero of an acceleration is known
            continue
        largest, middle = float(ranges.largest[x]), float(ranges.middle[x])
        yield from frictions(effect, variable(v), float(ranges.largest[v]))
        yield from springs(effect, variable(x), largest)
        yield from stops(effect, variable(x), largest, middle)
        yield from weights(effect, design, x, ranges)
        yield from frictions_by_position(effect, variable(x), variable(v))
        yield from rounded(effect, v, ranges)
        yield from yields(effect, x, v, ranges, middle)
        yield from remembering(effect, x, v, ranges.swing_of(x))
        moving |= {x, v}
    own = [variable(other) for other in sorted(moving)]
    for column in range(first, first + len(design.inputs)):
        if column not in moving:
            yield from of_input(effect, column, own, ranges)
