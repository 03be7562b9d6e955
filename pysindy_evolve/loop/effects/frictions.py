"""Dampings and frictions, of a velocity or of a slip between two bodies."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial

from ...operators import BUILTIN
from ...terms import Call, Sum, call, constant, mul, power
from .candidate import OFFSET, Candidate, CandidateMaker, Shape, bare
from .differences import gripping
from .kinks import magnitude, sign
from .names import (
    ASYMMETRIC_FRICTION,
    COULOMB_FRICTION,
    COUPLING,
    NONLINEAR_DAMPING,
    POSITION_FRICTION,
    QUADRATIC_DRAG,
    STRIBECK_FRICTION,
    VISCOUS_DAMPING,
)

# Speed of an exponential over the width of the bell that comes closest to it beside an offset and a
# line, by least squares over ten times that speed. It is tuned from there.
TUSTIN_SPEED_RATIO = 0.9
STRIBECK_SPEEDS = (0.03, 0.1, 0.3)  # as shares of the size of the velocity


def frictions(effect: CandidateMaker, v: Sum, speed: float) -> Iterator[Candidate]:
    """Yield dampings and frictions of a velocity, of which the largest magnitude is given."""
    yield effect(VISCOUS_DAMPING, v)
    yield effect(COULOMB_FRICTION, sign(v))
    yield effect(ASYMMETRIC_FRICTION, magnitude(v), parents=(OFFSET, sign(v)))
    yield from _stribecks(effect, v, speed)
    yield effect(QUADRATIC_DRAG, mul(v, magnitude(v)))
    yield effect(NONLINEAR_DAMPING, power(v, 3))


def frictions_by_position(effect: CandidateMaker, q: Sum, v: Sum) -> Iterator[Candidate]:
    """Yield dampings and frictions that change with the position."""
    yield effect(NONLINEAR_DAMPING, mul(power(q, 2), v))
    yield effect(POSITION_FRICTION, mul(magnitude(q), sign(v)))
    yield effect(POSITION_FRICTION, mul(power(q, 2), sign(v)))
    yield effect(POSITION_FRICTION, mul(q, sign(v)), parents=(sign(v),))
    yield effect(COUPLING, mul(q, v), parents=(OFFSET,))


def slips(effect: CandidateMaker, slip: Sum, reach: float) -> Iterator[Candidate]:
    """Yield dampings and frictions of the velocity of one body relative to another."""
    if reach == 0.0:  # one is a copy of the other
        return
    yield effect(COULOMB_FRICTION, sign(slip))
    yield from gripping(effect, COULOMB_FRICTION, slip, reach)
    yield from _stribecks(effect, slip, reach)
    yield effect(NONLINEAR_DAMPING, magnitude(slip), parents=(OFFSET,))
    yield effect(QUADRATIC_DRAG, mul(slip, magnitude(slip)))
    yield effect(NONLINEAR_DAMPING, power(slip, 3))


def _stribecks(effect: CandidateMaker, v: Sum, speed: float) -> Iterator[Candidate]:
    for share in STRIBECK_SPEEDS:
        shape = Shape((share * speed,), (partial(_stribeck, v),), meanings=("Stribeck speed",))
        yield effect(STRIBECK_FRICTION, shape=shape, parents=(bare(sign(v)),))


def tustin_form(candidate: Candidate) -> Candidate | None:
    """Return Stribeck friction that falls as exp(-|v| / v0), in the place of exp(-(v / v0)^2).

    Near rest it falls at once, as Tustin wrote it (1947); few records tell the two apart other than
    by their free runs. None in the place of any other effect.
    """
    if candidate.name != STRIBECK_FRICTION or candidate.shape is None:
        return None
    atoms = (atom for _, term in candidate.terms[0].parts for atom, _ in term.factors)
    velocities = [atom.args[0] for atom in atoms if isinstance(atom, Call) and _is_sign(atom)]
    if len(velocities) != 1:
        return None
    (speed,), (velocity,) = candidate.shape.values, velocities
    values, builds = (TUSTIN_SPEED_RATIO * speed,), (partial(_tustin, velocity),)
    shape = replace(candidate.shape, values=values, builds=builds)
    return replace(candidate, terms=shape.terms, shape=shape)


def _is_sign(atom: Call) -> bool:
    return atom.operator == BUILTIN["sgn"]


def _tustin(v: Sum, speed: float) -> Sum:
    return mul(sign(v), call(BUILTIN["exp"], mul(constant(-1.0 / speed), magnitude(v))))


def _stribeck(v: Sum, speed: float) -> Sum:
    """Return the sign of v with a bell around zero: friction that falls with the speed."""
    bell = call(BUILTIN["exp"], mul(constant(-1.0 / speed**2), power(v, 2)))
    return mul(sign(v), bell)
