"""Declared inputs that open a valve: it lets through the less the higher the pressure is."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from ...operators import BUILTIN
from ...terms import Sum, add, call, constant, mul, sub, variable
from ..given.design import Design
from ..given.ranges import Ranges
from .candidate import Candidate, CandidateMaker, Shape
from .names import VALVE
from .varying_terms import parts_of

SUPPLIES = (1.2, 2.0, 4.0)  # pressures of a supply, over the largest pressure of the record


def throttled(effect: CandidateMaker, design: Design, ranges: Ranges) -> Iterator[Candidate]:
    """Yield declared inputs as openings of a valve: flow goes with the root of a pressure.

    That is the supply less the pressure of the load, or plus it where the valve is reversed. A
    pressure that stays above zero is that of a chamber: the supply less this pressure drives the
    flow in, and the pressure itself drives it out.
    """
    state, inputs = effect.state, range(len(design.states), design.time)
    largest = float(ranges.largest[state])
    if design.position_of(state) is not None or largest == 0.0:
        return
    build = _of_chamber if ranges.stays_positive(state) else _of_load
    acting = parts_of(design, state)
    for opening in (u for u in map(variable, inputs) if u in acting):
        for share in SUPPLIES:
            supply = Shape(
                (share * largest,),
                (partial(build, opening, variable(state)),),
                meanings=("supply pressure",),
            )
            yield effect(VALVE, shape=supply, never_paired=True)


def _of_load(opening: Sum, pressure: Sum, supply: float) -> Sum:
    """Return an opening times the root of the supply less the pressure that it works against."""
    against = mul(call(BUILTIN["sgn"], opening), pressure)
    return mul(opening, _root(sub(constant(supply), against)))


def _of_chamber(opening: Sum, pressure: Sum, supply: float) -> Sum:
    """Return an opening times the root of what drives flow into a chamber, or out of it."""
    half = constant(0.5 * supply)
    inward = mul(call(BUILTIN["sgn"], opening), sub(half, pressure))
    return mul(opening, _root(add(half, inward)))


def _root(drop: Sum) -> Sum:
    """Return the root of a magnitude, as noise may lift a pressure above that of the supply."""
    return call(BUILTIN["sqrt"], call(BUILTIN["abs"], drop))
