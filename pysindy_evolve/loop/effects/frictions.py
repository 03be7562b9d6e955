"""Dampings and frictions, of a velocity or of a slip between two bodies."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial

import numpy as np

from ...operators import BUILTIN
from ...substitution import substituted
from ...terms import Call, Sum, as_sum, call, constant, mul, power
from .candidate import OFFSET, Candidate, CandidateMaker, Shape, bare, rewritten
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
from .slips import gripping

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
    form = rewritten(candidate, _with_speed_itself)
    if form.terms == candidate.terms or form.shape is None:
        return None
    (speed,) = form.shape.values
    shape = replace(form.shape, values=(TUSTIN_SPEED_RATIO * speed,))
    acts_at = form.acts_at
    if acts_at is not None:
        acts_at = (acts_at[0], tuple(map(_with_speed_itself, acts_at[1])))
    return replace(form, terms=shape.terms, shape=shape, acts_at=acts_at)


def _with_speed_itself(expression: Sum) -> Sum:
    """Replace each exp(-(v / c)^2) by exp(-|v| / c)."""
    straight: dict[int | Call, Sum] = {}
    for atom in (atom for _, term in expression.parts for atom, _ in term.factors):
        if isinstance(atom, Call) and atom.operator == BUILTIN["exp"]:
            exponent = _without_square(atom.args[0])
            if exponent is not None:
                straight[atom] = call(BUILTIN["exp"], exponent)
    return substituted(expression, straight) if straight else expression


def _without_square(exponent: Sum) -> Sum | None:
    """Return -|v| / c for -(v / c)^2; None for any other expression."""
    if len(exponent.parts) != 1:
        return None
    ((number, product),) = exponent.parts
    if number >= 0.0 or [power for _, power in product.factors] != [2]:
        return None
    ((velocity, _),) = product.factors
    return mul(constant(-float(np.sqrt(-number))), magnitude(as_sum(velocity)))


def _stribeck(v: Sum, speed: float) -> Sum:
    """Return the sign of v with a bell around zero: friction that falls with the speed."""
    bell = call(BUILTIN["exp"], mul(constant(-1.0 / speed**2), power(v, 2)))
    return mul(sign(v), bell)
