"""Declared sums as forces that saturate: the grip of a tyre levels off as its slip grows."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial

from ...terms import Product, Sum, Variable, constant, div, mul, variable
from ..given.design import Design
from ..given.ranges import Ranges
from .candidate import Candidate, CandidateMaker, Shape
from .hysteresis import rounded_sign
from .names import COUPLING
from .varying_terms import parts_of

GRIPS = (0.03, 0.1, 0.3, 1.0)  # differences at which a grip saturates, as shares of the largest one


def leveling(effect: CandidateMaker, design: Design, ranges: Ranges) -> Iterator[Candidate]:
    """Yield declared slips as forces that saturate at a grip.

    A slip is a sum of variables, such as the angle of a wheel less that of its motion. Some of them
    may be over a speed that stays above zero, as a rate of turn is, and so may the force. The same
    slip may stand in two equations: that of a sideways motion, and that of a rotation.
    """
    speeds = [v for v in range(design.time) if ranges.stays_positive(v)]
    for part in parts_of(design, effect.state):
        if _is_slip(part, speeds):
            slip = _in_unit_of_variable(part)
            grips = gripping(effect, COUPLING, slip, _largest(slip, ranges))
            yield from (replace(one, acts_at=((min(slip.variables),), one.terms)) for one in grips)
        for speed in sorted(part.variables & frozenset(speeds)):
            carried = mul(part, variable(speed))
            if _is_slip(carried, speeds, alone=False):
                slip = _in_unit_of_variable(carried)
                yield from gripping(effect, COUPLING, slip, _largest(slip, ranges), speed)


def gripping(
    effect: CandidateMaker, name: str, slip: Sum, reach: float, speed: int | None = None
) -> Iterator[Candidate]:
    """Yield forces by a difference that saturate; `reach` is the largest difference.

    With a speed, they are divided by it.
    """
    if reach == 0.0:  # one is a copy of the other
        return
    for share in GRIPS:
        build = partial(rounded_sign, slip) if speed is None else partial(_grip_over, slip, speed)
        meanings = ("difference where it levels off",)
        yield effect(name, shape=Shape((share * reach,), (build,), meanings=meanings))


def _grip_over(slip: Sum, speed: int, width: float) -> Sum:
    """Return tanh(slip / width) over a speed."""
    return div(rounded_sign(slip, width), variable(speed))


def _is_slip(part: Sum, speeds: Sequence[int], *, alone: bool = True) -> bool:
    """Tell whether a part is a sum of variables, some of them over a speed.

    The difference of two variables alone is tried for all states of one kind, see differences.py.
    """
    plain = [weight for weight, term in part.parts if _is_variable(term)]
    over = [term for _, term in part.parts if _is_over_speed(term, speeds)]
    is_difference = alone and len(plain) == 2 and not over and plain[0] == -plain[1]
    return bool(plain) and 1 < len(plain) + len(over) == len(part.parts) and not is_difference


def _in_unit_of_variable(slip: Sum) -> Sum:
    """Return a slip with the weight one before the variable in it that has the largest."""
    return div(slip, constant(max((w for w, term in slip.parts if _is_variable(term)), key=abs)))


def _is_variable(term: Product) -> bool:
    return term.size == 1 and bool(term.variables)


def _is_over_speed(term: Product, speeds: Sequence[int]) -> bool:
    """Tell whether a term is a variable over a speed."""
    indices = {atom.index: n for atom, n in term.factors if isinstance(atom, Variable)}
    below = [v for v, exponent in indices.items() if exponent == -1 and v in speeds]
    return len(term.factors) == len(indices) == 2 and sum(indices.values()) == 0 and bool(below)


def _largest(slip: Sum, ranges: Ranges) -> float:
    """Return a bound of the magnitude of a slip."""
    total = 0.0
    for weight, term in slip.parts:
        factors = [(atom.index, n) for atom, n in term.factors if isinstance(atom, Variable)]
        above = [float(ranges.largest[v]) for v, n in factors if n > 0]
        below = [ranges.smallest(v) for v, n in factors if n < 0]
        total += abs(weight) * math.prod(above) / math.prod(below)
    return total
