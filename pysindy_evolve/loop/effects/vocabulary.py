"""The vocabulary: effects that engineers know by name, and the terms that each of them stands for.

Squares, products, absolute values and time have a mean, so each of them can pose as an offset. They
may enter only where the constant itself already stands (the marginality principle of regression,
Nelder 1977, DOI 10.2307/2344517).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from itertools import combinations

import numpy as np

from ...operators import BUILTIN
from ...terms import Sum, add, call, constant, mul, power, sub, variable
from ..given.design import Design
from .angles import (
    angles_of,
    bends,
    between_angles,
    centrifugal,
    centripetal,
    swing_of,
    units_of,
)
from .candidate import OFFSET, Candidate, CandidateMaker, Shape, bare, rewritten
from .differences import (
    acting_differences,
    differences,
    gripping,
    leveling,
    losses,
    radiated,
)
from .entries import Entry, entries_of
from .hysteresis import remembering, rounded, yields
from .links import link_couplings, link_weights
from .names import (
    ASYMMETRIC_FRICTION,
    CONSTANT_OFFSET,
    COULOMB_FRICTION,
    COUPLING,
    CUBIC_STIFFNESS,
    DEAD_ZONE,
    GRAVITY,
    HARMONIC,
    INPUT_GAIN,
    INPUT_NONLINEARITY,
    LINEAR_STIFFNESS,
    NONLINEAR_DAMPING,
    POSITION_FRICTION,
    QUADRATIC_DRAG,
    QUADRATIC_STIFFNESS,
    QUINTIC_STIFFNESS,
    SATURATION,
    STRIBECK_FRICTION,
    VISCOUS_DAMPING,
)
from .radial import radial
from .saturating import saturating
from .stops import asymmetric_limits, damped_contacts, stops
from .valves import throttled
from .varying import drifts, varying

__all__ = ["of_equation"]

# Stribeck speeds and widths of dead zones and saturations, as shares of the size of the signal.
STRIBECK_SPEEDS = (0.03, 0.1, 0.3)
DEAD_ZONES = (0.03, 0.08, 0.2, 0.5)
SATURATIONS = (0.08, 0.2, 0.35, 0.5, 0.7, 0.9)


def _abs(a: Sum) -> Sum:
    return call(BUILTIN["abs"], a)


def _sgn(a: Sum) -> Sum:
    return call(BUILTIN["sgn"], a)


def _clipped(a: Sum, limit: float) -> Sum:
    """Return a between -limit and limit, written with absolute values."""
    edge = constant(limit)
    return mul(constant(0.5), sub(_abs(add(a, edge)), _abs(sub(a, edge))))


def _beyond(a: Sum, limit: float) -> Sum:
    """Return how far a lies outside of -limit to limit."""
    return sub(a, _clipped(a, limit))


def _stribeck(v: Sum, speed: float) -> Sum:
    """Return the sign of v with a bell around zero: friction that falls with the speed."""
    bell = call(BUILTIN["exp"], mul(constant(-1.0 / speed**2), power(v, 2)))
    return mul(_sgn(v), bell)


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
    yield from _frictions(effect, v, float(scales[state]))
    if position is not None:
        q = variable(position)
        yield from _springs(effect, q, float(scales[position]))
        yield from stops(effect, q, float(scales[position]), float(middle[position]))
        yield from damped_contacts(effect, design, q, v)
        yield from _weights(effect, design, position, scales, middle)
        yield from _with_position(effect, q, v)
        yield from centripetal(effect, design, turning)
        yield from centrifugal(effect, design, position, turning)
    own = state if position is None else position
    for other in range(n_states):
        if other not in (state, position):
            yield from _couplings(effect, state, other)
            yield from differences(effect, design, state, other, apart)
            yield from _between(effect, design, state, other, apart)
            if {own, other} <= turning:
                yield from between_angles(effect, variable(own), variable(other))
    yield from _products_of_others(effect, design, {state, position})
    if position is None:
        yield from radiated(effect, design, scales, middle)
    for column in range(n_states, design.time):
        states = [v] if position is None else [v, variable(position)]
        u, reach = variable(column), float(scales[column])
        yield from _inputs(effect, u, states, reach, float(middle[column]))
        if position is None:
            yield from losses(effect, design, column)
    yield from _relative(effect, design, state, apart)
    yield from leveling(effect, design, scales)
    yield from radial(effect, design, turning)
    entries = entries_of(design, state)
    yield from _at_joints(effect, design, entries, scales, turning)
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
        yield from _frictions(effect, variable(v), float(scales[v]))
        yield from _springs(effect, variable(x), float(scales[x]))
        yield from stops(effect, variable(x), float(scales[x]), float(middle[x]))
        yield from _weights(effect, design, x, scales, middle)
        yield from _with_position(effect, variable(x), variable(v))
        yield from rounded(effect, v, scales)
        yield from yields(effect, x, v, scales, float(middle[x]))
        yield from remembering(effect, x, v, float(scales[x]) - abs(float(middle[x])))
        moving |= {x, v}
    for column in range(first, first + len(design.inputs)):
        if column not in moving:
            own = [variable(other) for other in sorted(moving)]
            u, reach = variable(column), float(scales[column])
            yield from _inputs(effect, u, own, reach, float(middle[column]))


def _frictions(effect: CandidateMaker, v: Sum, speed: float) -> Iterator[Candidate]:
    yield effect(VISCOUS_DAMPING, v)
    yield effect(COULOMB_FRICTION, _sgn(v))
    yield effect(ASYMMETRIC_FRICTION, _abs(v), parents=(OFFSET, _sgn(v)))
    yield from _stribecks(effect, v, speed)
    yield effect(QUADRATIC_DRAG, mul(v, _abs(v)))
    yield effect(NONLINEAR_DAMPING, power(v, 3))


def _stribecks(effect: CandidateMaker, v: Sum, speed: float) -> Iterator[Candidate]:
    for share in STRIBECK_SPEEDS:
        shape = Shape((share * speed,), (partial(_stribeck, v),), meanings=("Stribeck speed",))
        yield effect(STRIBECK_FRICTION, shape=shape, parents=(bare(_sgn(v)),))


def _springs(effect: CandidateMaker, q: Sum, reach: float) -> Iterator[Candidate]:
    yield effect(LINEAR_STIFFNESS, q)
    yield effect(QUADRATIC_STIFFNESS, power(q, 2), parents=(OFFSET,))
    yield effect(CUBIC_STIFFNESS, power(q, 3))
    yield effect(QUINTIC_STIFFNESS, power(q, 5))
    for share in DEAD_ZONES:
        yield effect(DEAD_ZONE, shape=_half_width(share * reach, q))


def _half_width(width: float, q: Sum) -> Shape:
    return Shape((width,), (partial(_beyond, q),), meanings=("half width",))


def _weights(
    effect: CandidateMaker, design: Design, position: int, scales: np.ndarray, middle: np.ndarray
) -> Iterator[Candidate]:
    """Yield gravity on an angle, with an arbitrary zero if it swings far."""
    swing = swing_of(position, scales, middle)
    for unit in units_of(design, position, scales, middle):
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


def _with_position(effect: CandidateMaker, q: Sum, v: Sum) -> Iterator[Candidate]:
    """Yield dampings and frictions that change with the position."""
    yield effect(NONLINEAR_DAMPING, mul(power(q, 2), v))
    yield effect(POSITION_FRICTION, mul(_abs(q), _sgn(v)))
    yield effect(POSITION_FRICTION, mul(power(q, 2), _sgn(v)))
    yield effect(POSITION_FRICTION, mul(q, _sgn(v)), parents=(_sgn(v),))
    yield effect(COUPLING, mul(q, v), parents=(OFFSET,))


def _at_joints(
    effect: CandidateMaker,
    design: Design,
    entries: Sequence[Entry],
    scales: np.ndarray,
    turning: frozenset[int],
) -> Iterator[Candidate]:
    """Yield forces that enter where a declared force does, with a factor that is not constant."""
    for entry in entries:
        forces = [effect(CONSTANT_OFFSET, OFFSET), *centripetal(effect, design, turning)]
        for v in entry.velocities:
            forces += _frictions(effect, variable(v), float(scales[v]))
            q = design.position_of(v)
            if q is not None:
                forces += _springs(effect, variable(q), float(scales[q]))
        # Without its sign, the factor -q^2 of a damping makes a spring q the cubic stiffness, which
        # has its name already.
        is_free = len(entry.factor.parts) == 1 and not entry.is_known
        factor = bare(entry.factor) if is_free else entry.factor
        for force in forces:
            entering = rewritten(force, partial(mul, factor))
            yield replace(entering, never_paired=True, acts_at=((entry.beside,), force.terms))


def _couplings(effect: CandidateMaker, state: int, other: int) -> Iterator[Candidate]:
    own, w = variable(state), variable(other)
    yield effect(COUPLING, w)
    yield effect(COUPLING, mul(own, w), parents=(OFFSET,))
    yield effect(COUPLING, power(w, 2), parents=(OFFSET,))


def _products_of_others(
    effect: CandidateMaker, design: Design, own: set[int | None]
) -> Iterator[Candidate]:
    """Yield products of two other states: a reaction, a gyroscopic moment."""
    others = set(range(len(design.states))) - own
    rates = [s for s in sorted(others) if design.derivative_of(s) is None]
    for one, other in combinations(rates, 2):
        yield effect(COUPLING, mul(variable(one), variable(other)), parents=(OFFSET,))


def _between(
    effect: CandidateMaker, design: Design, state: int, other: int, apart: np.ndarray
) -> Iterator[Candidate]:
    """Yield the forces between two bodies, which depend on their relative motion."""
    position = design.position_of(state)
    if position is None:
        return
    if design.position_of(other) is not None:
        slip = sub(variable(state), variable(other))
        yield from _slips(effect, slip, float(apart[state, other]))
    if design.derivative_of(other) is not None:
        stretch = sub(variable(position), variable(other))
        yield from _stretches(effect, stretch, float(apart[position, other]))


def _slips(effect: CandidateMaker, slip: Sum, reach: float) -> Iterator[Candidate]:
    if reach == 0.0:  # one is a copy of the other
        return
    yield effect(COULOMB_FRICTION, _sgn(slip))
    yield from gripping(effect, COULOMB_FRICTION, slip, reach)
    yield from _stribecks(effect, slip, reach)
    yield effect(NONLINEAR_DAMPING, _abs(slip), parents=(OFFSET,))
    yield effect(QUADRATIC_DRAG, mul(slip, _abs(slip)))
    yield effect(NONLINEAR_DAMPING, power(slip, 3))


def _stretches(effect: CandidateMaker, stretch: Sum, reach: float) -> Iterator[Candidate]:
    yield effect(QUADRATIC_STIFFNESS, power(stretch, 2), parents=(OFFSET,))
    yield effect(CUBIC_STIFFNESS, power(stretch, 3))
    for share in DEAD_ZONES:
        yield effect(DEAD_ZONE, shape=_half_width(share * reach, stretch))
    yield from stops(effect, stretch, reach, 0.0)


def _relative(
    effect: CandidateMaker, design: Design, state: int, apart: np.ndarray
) -> Iterator[Candidate]:
    """Yield the forces of a motion relative to an input: to the wind, or to a shaken floor."""
    for own, other in acting_differences(design, state):
        between = sub(variable(own), variable(other))
        if own == state:
            yield from _slips(effect, between, float(apart[own, other]))
        else:
            yield from _stretches(effect, between, float(apart[own, other]))


def _inputs(
    effect: CandidateMaker, u: Sum, own: list[Sum], reach: float, middle: float
) -> Iterator[Candidate]:
    yield effect(INPUT_GAIN, u)
    for x in own:
        yield effect(INPUT_GAIN, mul(u, x), parents=(OFFSET,))
    yield effect(INPUT_NONLINEARITY, power(u, 2), parents=(OFFSET,))
    yield effect(INPUT_NONLINEARITY, mul(u, _abs(u)))
    yield effect(INPUT_NONLINEARITY, power(u, 3))
    for share in SATURATIONS:
        shape = Shape((share * reach,), (partial(_clipped, u),), meanings=("limit",))
        yield effect(SATURATION, shape=shape)
    yield from asymmetric_limits(effect, u, reach, middle)
