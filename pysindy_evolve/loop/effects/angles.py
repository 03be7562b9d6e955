"""Forces of rotating bodies: periodic functions of an angle, or of the difference of two."""

from __future__ import annotations

import math
from collections.abc import Iterator

from ...operators import BUILTIN
from ...substitution import substituted
from ...terms import (
    ONE,
    Call,
    Product,
    Sum,
    call,
    constant,
    mul,
    of_term,
    only_term,
    power,
    sub,
    variable,
)
from ..given.design import Design
from ..given.ranges import Ranges
from .candidate import OFFSET, Candidate, CandidateMaker
from .names import COUPLING, INPUT_GAIN

RADIAN, DEGREE = 1.0, math.pi / 180.0
UNITS = (RADIAN, DEGREE)  # units of angles, in radians
BENT = 30.0  # degrees of swing, from which on a sine is clearly no straight line
WAVES = (BUILTIN["sin"], BUILTIN["cos"])


def angles_of(design: Design) -> frozenset[int]:
    """Return the variables that are angles: they stand in a sine or cosine of the model."""
    sides = [*design.fixed, *(part for column in design.columns for part in column.parts)]
    return frozenset().union(*map(_in_waves, sides))


def waves_angles(expression: Sum, design: Design) -> bool:
    """Tell whether an expression has sines or cosines, and all are of angles of a model."""
    waved = _in_waves(expression)
    return bool(waved) and waved <= angles_of(design)


def units_of(design: Design, variable: int, ranges: Ranges) -> tuple[float, ...]:
    """Return the units, in radians, that a variable may be measured in if it is an angle.

    Degrees are possible only if it swings by more than 30 of them, as the height of a fall from
    forty metres does not, and if no sine of the model tells the unit.
    """
    if not bends(ranges.swing_of(variable), DEGREE) or variable in angles_of(design):
        return (RADIAN,)
    return UNITS


def bends(swing: float, unit: float) -> bool:
    """Tell whether sine and cosine are clearly no straight lines over a swing in some unit."""
    return swing * unit > math.radians(BENT)


def without_turns(term: Product) -> Product:
    """Return a term with the phases of its sines and cosines reduced to at most half a turn."""
    plain: dict[int | Call, Sum] = {}
    for atom, _ in term.factors:
        if isinstance(atom, Call) and atom.operator in WAVES:
            phase = _phase(atom)
            turns = round(phase / (2.0 * math.pi))
            if turns:
                argument = sub(atom.args[0], constant(2.0 * math.pi * turns))
                plain[atom] = call(atom.operator, argument)
    if not plain:
        return term
    return only_term(substituted(of_term(term), plain))


def is_wave_of(term: Product, variable: int) -> bool:
    """Tell whether a term is the sine or cosine of an angle in radians, with any zero."""
    if len(term.factors) != 1:
        return False
    ((atom, power),) = term.factors
    if power != 1 or not isinstance(atom, Call) or atom.operator not in WAVES:
        return False
    angle = sub(atom.args[0], constant(_phase(atom)))
    return angle.variables == {variable} and angle.constants == () and angle.size == 1


def _phase(wave: Call) -> float:
    return next((c for c, part in wave.args[0].parts if part == ONE), 0.0)


def _in_waves(expression: Sum) -> frozenset[int]:
    found: frozenset[int] = frozenset()
    for _, term in expression.parts:
        for atom, _ in term.factors:
            if isinstance(atom, Call) and atom.operator in WAVES:
                found |= atom.variables
            elif isinstance(atom, Call):
                found = found.union(*map(_in_waves, atom.args))
            elif isinstance(atom, Sum):
                found |= _in_waves(atom)
    return found


def between_angles(effect: CandidateMaker, own: Sum, other: Sum) -> Iterator[Candidate]:
    """Yield what one angle does to another one, in the equation of that angle or of its speed."""
    apart = sub(other, own)
    yield effect(COUPLING, call(BUILTIN["sin"], apart))
    yield effect(COUPLING, call(BUILTIN["cos"], apart), parents=(OFFSET,), contains_parents=True)
    yield effect(COUPLING, call(BUILTIN["sin"], mul(constant(2.0), apart)))


def centripetal(
    effect: CandidateMaker, design: Design, turning: frozenset[int]
) -> Iterator[Candidate]:
    """Yield what a mass on a rotating arm does to the body that carries it, which may turn too."""
    for angle in sorted(turning):
        rate = design.derivative_of(angle) if angle < len(design.states) else None
        if rate is not None and rate != effect.state:
            own, other = variable(effect.state), variable(rate)
            square = power(other, 2)
            for wave in WAVES:
                yield effect(COUPLING, mul(square, call(wave, variable(angle))))
            for lever in _levers(angle, turning):
                yield effect(COUPLING, mul(mul(own, other), lever))


def centrifugal(
    effect: CandidateMaker, design: Design, position: int, turning: frozenset[int]
) -> Iterator[Candidate]:
    """Yield centrifugal forces by the rotation of another axis, on a hinged arm or on a slide.

    The speed of that axis is a state, or an input that does not act in the equation yet.
    """
    sides = design.sides_of(effect.state)
    axes = [rate for rate in design.velocities if rate != effect.state]
    inputs = range(len(design.states), design.time)
    unused = [u for u in inputs if not any(u in side.variables for side in sides)]
    levers = _levers(position, turning)
    for rate in axes:
        for lever in levers:
            yield effect(COUPLING, mul(power(variable(rate), 2), lever))
    for rate in unused:
        yield effect(INPUT_GAIN, mul(power(variable(rate), 2), levers[0]))


def _levers(position: int, turning: frozenset[int]) -> list[Sum]:
    """Return the factors that the squared speed of rotation may have in a centrifugal force.

    A mass on a turntable is driven out by w^2 r, one in a turning hoop by w^2 sin(q) cos(q), and
    the second link of an arm by w^2 sin(q), with q between the links, or cos(q), with another zero.
    """
    q = variable(position)
    if position not in turning:
        return [q]
    sine, cosine = (call(wave, q) for wave in WAVES)
    return [mul(sine, cosine), sine, cosine]
