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

from ...operators import BUILTIN
from ...terms import Sum, add, call, constant, mul, power, sub, variable
from ..given.design import Design
from ..given.ranges import Ranges
from .angles import RADIAN, WAVES, bends
from .candidate import Candidate, CandidateMaker
from .entries import Entry
from .names import COUPLING, GRAVITY


def link_weights(
    effect: CandidateMaker,
    design: Design,
    entries: Sequence[Entry],
    ranges: Ranges,
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
    ranges : Ranges
        Ranges of the variables.
    turning : frozenset of int
        Variables that are angles, in radians.

    Yields
    ------
    Candidate
        Only of links that swing so far that their weight is no offset with a spring.
    """
    for angles, places in _chains(design, entries, turning):
        swing = sum(map(ranges.swing_of, angles))
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
        exchanged = list(_exchanged(design, one, other, turning))
        for joints in product(_at_joint(entries, one), _at_joint(entries, other)):
            if joints[0] != joints[1]:
                yield from (_at_both(effect, design, joints, forces) for forces in exchanged)


def _at_both(
    effect: CandidateMaker, design: Design, joints: Sequence[Entry | None], forces: tuple[Sum, Sum]
) -> Candidate:
    """Return the forces at two joints as one effect; nothing acts where a joint has no entry."""
    acting = [
        (joint, force) for joint, force in zip(joints, forces, strict=True) if joint is not None
    ]
    torques = (mul(_torque_factor(joint, design), force) for joint, force in acting)
    candidate = effect(COUPLING, reduce(add, torques), never_paired=True)
    places = tuple(joint.beside for joint, _ in acting)
    return replace(candidate, acts_at=(places, tuple(force for _, force in acting)))


def _at_joint(entries: Sequence[Entry], velocity: int) -> Sequence[Entry | None]:
    """Return the entries that may be at the joint of a velocity; None if it has none here.

    The inertia of a slide on a turntable couples no accelerations, only velocities.
    """
    return [entry for entry in entries if velocity in entry.velocities] or [None]


def _exchanged(
    design: Design, one: int, other: int, turning: frozenset[int]
) -> Iterator[tuple[Sum, Sum]]:
    """Yield the forces at two joints, by their velocities, for one unit of the moving mass.

    The second joint turns or slides; if both angles are counted from a fixed direction, only their
    difference matters.
    """
    angle, position = design.position_of(one), design.position_of(other)
    if position is None:
        return
    if position in turning:
        yield from _at_elbow(one, other, position)
    else:
        yield _along_slide(one, other, position)
    if angle is not None and {angle, position} <= turning and angle < position:
        yield _between_directions(one, other, angle, position)


def _at_elbow(one: int, other: int, angle: int) -> Iterator[tuple[Sum, Sum]]:
    """Yield the forces of an elbow, whose angle is that between the links, from any zero."""
    w, bending = variable(one), variable(other)
    along = add(mul(constant(2.0), mul(w, bending)), power(bending, 2))
    for wave in WAVES:
        bent = call(wave, variable(angle))
        yield mul(bent, along), mul(constant(-1.0), mul(bent, power(w, 2)))


def _along_slide(one: int, other: int, position: int) -> tuple[Sum, Sum]:
    """Return the forces of a mass that is carried round on a slide."""
    w, r = variable(one), variable(position)
    return mul(constant(-2.0), mul(r, mul(w, variable(other)))), mul(r, power(w, 2))


def _between_directions(one: int, other: int, angle: int, position: int) -> tuple[Sum, Sum]:
    """Return the forces of two links whose angles are both counted from a fixed direction."""
    apart = call(BUILTIN["sin"], sub(variable(angle), variable(position)))
    first, second = power(variable(one), 2), power(variable(other), 2)
    return mul(constant(-1.0), mul(apart, second)), mul(apart, first)


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
