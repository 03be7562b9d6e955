"""Forces of the links of an arm, which act at several joints with one number.

A link points where the angles of the joints before it add up to. Its weight has the potential
m g l sin(q1 + q2), so it pulls with m g l cos(q1 + q2) at both joints. Links that move relative to
each other exchange Coriolis and centrifugal forces. Through the inverse mass matrix each of these
torques acts in all equations.

References
----------
Siciliano, Sciavicco, Villani, Oriolo, "Robotics" (2009), chapter 7: the arm with two links.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import reduce
from itertools import combinations, permutations, product

import numpy as np

from ...operators import BUILTIN
from ...terms import Sum, add, call, constant, mul, power, sub, variable
from ..given.design import Design
from .angles import RADIAN, WAVES, bends, swing_of
from .candidate import Candidate, CandidateMaker
from .entries import Entry
from .names import COUPLING, GRAVITY

__all__ = ["link_couplings", "link_weights"]


def link_weights(
    effect: CandidateMaker,
    design: Design,
    entries: Sequence[Entry],
    scales: np.ndarray,
    middle: np.ndarray,
    turning: frozenset[int],
) -> Iterator[Candidate]:
    """Yield the weights of the links of an arm, in the equation of one joint.

    Parameters
    ----------
    effect : CandidateMaker
        Makes the candidates of the equation.
    design : Design
        The model so far.
    entries : sequence of Entry
        Where forces enter the equation.
    scales, middle : ndarray of shape (n_variables,)
        Largest magnitude and middle of the range of each variable.
    turning : frozenset of int
        Variables that are angles, in radians.

    Yields
    ------
    Candidate
        Only of links that swing so far that their weight is no offset with a spring.
    """
    for angles, places in _chains(design, entries, turning):
        swing = sum(swing_of(angle, scales, middle) for angle in angles)
        if bends(swing, RADIAN):
            direction = reduce(add, map(variable, angles))
            factor = reduce(add, (_torque_factor(entry, design) for entry in places))
            force = tuple(entry.beside for entry in places)
            for wave in WAVES:
                weight = call(wave, direction)
                candidate = effect(GRAVITY, mul(factor, weight), never_paired=True)
                yield replace(candidate, acts_at=(force, (weight,)))


def link_couplings(
    effect: CandidateMaker, design: Design, entries: Sequence[Entry], turning: frozenset[int]
) -> Iterator[Candidate]:
    """Yield the Coriolis and centrifugal forces between two joints, in the equation of one.

    Parameters
    ----------
    effect, design, entries, turning
        As in `link_weights`.

    Yields
    ------
    Candidate
        Each is one force at both joints.
    """
    for one, other in permutations(design.velocities, 2):
        forces = list(_exchanged(design, one, other, turning))
        for places in product(*(_at_joint(entries, velocity) for velocity in (one, other))):
            acting = [(place, k) for k, place in enumerate(places) if place is not None]
            if acting and places[0] != places[1]:
                beside = tuple(place.beside for place, _ in acting)
                for pair in forces:
                    torques = (mul(_torque_factor(place, design), pair[k]) for place, k in acting)
                    candidate = effect(COUPLING, reduce(add, torques), never_paired=True)
                    yield replace(candidate, acts_at=(beside, tuple(pair[k] for _, k in acting)))


def _at_joint(entries: Sequence[Entry], velocity: int) -> Sequence[Entry | None]:
    """Return the entries that may be at the joint of a velocity; None if it has none here.

    The inertia of a slide on a turntable couples no accelerations, only velocities.
    """
    return [entry for entry in entries if velocity in entry.velocities] or [None]


def _exchanged(
    design: Design, one: int, other: int, turning: frozenset[int]
) -> Iterator[tuple[Sum, Sum]]:
    """Yield the forces at two joints, by their velocities, for one unit of the moving mass.

    The second joint is an elbow, whose angle is that between the links; or both angles are counted
    from a fixed direction; or the second joint is a slide, along which the mass is carried round.
    """
    w, w_other = variable(one), variable(other)
    squares = power(w, 2), power(w_other, 2)
    angle, position = design.position_of(one), design.position_of(other)
    if position is None:
        return
    along = add(mul(constant(2.0), mul(w, w_other)), squares[1])
    if position in turning:
        for wave in WAVES:
            bent = call(wave, variable(position))
            yield mul(bent, along), mul(constant(-1.0), mul(bent, squares[0]))
    else:
        r = variable(position)
        yield mul(constant(-2.0), mul(r, mul(w, w_other))), mul(r, squares[0])
    if angle is not None and {angle, position} <= turning and angle < position:
        apart = call(BUILTIN["sin"], sub(variable(angle), variable(position)))
        yield mul(constant(-1.0), mul(apart, squares[1])), mul(apart, squares[0])


def _chains(
    design: Design, entries: Sequence[Entry], turning: frozenset[int]
) -> Iterator[tuple[tuple[int, ...], tuple[Entry, ...]]]:
    """Yield runs of joints, as a link is lifted by all joints before it, and their torques.

    Without a declared damping, nobody knows at which joint an input acts, so all are tried.
    """
    rates = {q: v for v in design.velocities if (q := design.position_of(v)) in turning}
    joints = sorted(rates)
    for first, last in combinations(range(len(joints) + 1), 2):
        angles = tuple(joints[first:last])
        needed = {rates[angle] for angle in angles}
        for places in combinations(entries, len(angles)):
            able = [needed.intersection(entry.velocities) for entry in places]
            if all(able) and needed == set().union(*able):
                yield angles, places


def _torque_factor(entry: Entry, design: Design) -> Sum:
    """Return the factor of a torque; that of a damping, declared as -d w, has the opposite sign."""
    is_input = entry.beside >= len(design.states)
    return entry.factor if is_input else mul(constant(-1.0), entry.factor)
