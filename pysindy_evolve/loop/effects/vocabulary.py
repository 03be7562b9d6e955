"""The vocabulary: effects that engineers know by name, equation by equation, simple ones first.

Each effect is built in the file that its kind is named after. Squares, products, absolute values
and time have a mean, so each of them can pose as an offset. They may enter only where the constant
itself already stands (the marginality principle of regression, Nelder 1977, DOI 10.2307/2344517).
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ...terms import Sum, variable
from ..given.design import Design
from .angles import angles_of, between_angles, centrifugal, centripetal
from .candidate import OFFSET, Candidate, CandidateMaker
from .couplings import between, couplings, products_of_others, relative
from .differences import differences, leveling, losses, radiated
from .entries import entries_of
from .frictions import frictions, frictions_by_position
from .hysteresis import remembering, rounded, yields
from .inputs import of_input, within_terms
from .joints import at_joints
from .links import link_couplings, link_weights
from .names import CONSTANT_OFFSET
from .radial import radial
from .saturating import saturating
from .springs import springs
from .stops import damped_contacts, stops
from .valves import throttled
from .varying import drifts, varying
from .weights import weights


def of_equation(
    design: Design, state: int, scales: np.ndarray, apart: np.ndarray, middle: np.ndarray
) -> Iterator[Candidate]:
    """Yield the vocabulary for one equation, simple effects before composed ones.

    A term of several effects, such as the square of a position, has the name of the first.
    """
    effect = CandidateMaker(state)
    if design.algebraic:
        found = _of_target(effect, design, scales, middle)
    else:
        found = _of_rate(effect, design, scales, apart, middle)
    seen: set[tuple[Sum, ...]] = set()
    for candidate in found:
        if candidate.terms not in seen:
            seen.add(candidate.terms)
            yield candidate


def _of_rate(
    effect: CandidateMaker,
    design: Design,
    scales: np.ndarray,
    apart: np.ndarray,
    middle: np.ndarray,
) -> Iterator[Candidate]:
    """Yield the effects in the rate of a state."""
    state, n_states = effect.state, len(design.states)
    v, position, turning = variable(state), design.position_of(state), angles_of(design)
    yield effect(CONSTANT_OFFSET, OFFSET)
    yield from frictions(effect, v, float(scales[state]))
    if position is not None:
        q = variable(position)
        yield from springs(effect, q, float(scales[position]))
        yield from stops(effect, q, float(scales[position]), float(middle[position]))
        yield from damped_contacts(effect, design, q, v)
        yield from weights(effect, design, position, scales, middle)
        yield from frictions_by_position(effect, q, v)
        yield from centripetal(effect, design, turning)
        yield from centrifugal(effect, design, position, turning)
    own = state if position is None else position
    for other in range(n_states):
        if other not in (state, position):
            yield from couplings(effect, state, other)
            yield from differences(effect, design, state, other, apart)
            yield from between(effect, design, state, other, apart)
            if {own, other} <= turning:
                yield from between_angles(effect, variable(own), variable(other))
    yield from products_of_others(effect, design, {state, position})
    if position is None:
        yield from radiated(effect, design, scales, middle)
    for column in range(n_states, design.time):
        states = [v] if position is None else [v, variable(position)]
        u, reach = variable(column), float(scales[column])
        yield from of_input(effect, u, states, reach, float(middle[column]))
        yield from within_terms(effect, design, column, reach)
        if position is None:
            yield from losses(effect, design, column)
    yield from relative(effect, design, state, apart)
    yield from leveling(effect, design, scales)
    yield from radial(effect, design, turning)
    entries = entries_of(design, state)
    yield from at_joints(effect, design, entries, scales, turning)
    yield from link_weights(effect, design, entries, scales, middle, turning)
    yield from link_couplings(effect, design, entries, turning)
    yield from varying(effect, design)
    yield from saturating(effect, design, scales, middle)
    yield from throttled(effect, design, scales, middle)
    yield from drifts(effect, design, variable(design.time))


def _of_target(
    effect: CandidateMaker, design: Design, scales: np.ndarray, middle: np.ndarray
) -> Iterator[Candidate]:
    """Yield the effects in a target that is a function of inputs."""
    yield effect(CONSTANT_OFFSET, OFFSET)
    first = len(design.states)
    velocities = {v for _, v in design.motions}
    moving: set[int] = set()
    for x, v in design.motions:
        if x in velocities:  # velocity and acceleration
            yield from yields(effect, v, x, scales, 0.0)  # the zero of an acceleration is known
            continue
        yield from frictions(effect, variable(v), float(scales[v]))
        yield from springs(effect, variable(x), float(scales[x]))
        yield from stops(effect, variable(x), float(scales[x]), float(middle[x]))
        yield from weights(effect, design, x, scales, middle)
        yield from frictions_by_position(effect, variable(x), variable(v))
        yield from rounded(effect, v, scales)
        yield from yields(effect, x, v, scales, float(middle[x]))
        yield from remembering(effect, x, v, float(scales[x]) - abs(float(middle[x])))
        moving |= {x, v}
    for column in range(first, first + len(design.inputs)):
        if column not in moving:
            own = [variable(other) for other in sorted(moving)]
            u, reach = variable(column), float(scales[column])
            yield from of_input(effect, u, own, reach, float(middle[column]))
