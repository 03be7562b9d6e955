"""What a declared term is worth may change: with what was measured, or with the time.

A fan cools better the faster it turns, prey is caught less the more of it there is, a spring
softens as it warms up, a tank grows lighter as it runs out.
"""

from __future__ import annotations

from collections.abc import Iterator

from ...terms import Call, Sum, mul, variable
from ..given.design import Design
from .angles import angles_of
from .candidate import OFFSET, Candidate, CandidateMaker, bare
from .periodic import FORCING

__all__ = ["drifts", "parts_of", "varying"]


def varying(effect: CandidateMaker, design: Design) -> Iterator[Candidate]:
    """Go through each declared term times a state or an input; squares have names of their own.

    An angle is left out: what changes with it is the same after a turn, and so no multiple of it.
    """
    acting = set(range(design.time)) - angles_of(design)
    for part in parts_of(design, effect.state):
        for other in map(variable, sorted(acting)):
            both = part.variables | other.variables
            in_time = design.time in both
            name = _in_time(part) if in_time else _name_of(both, design, effect.state)
            if other != part and name:
                yield effect(name, mul(other, part), parents=(OFFSET, part), alone=True)


def _in_time(part: Sum) -> str:
    """Return what a term that changes with the time is called, with another variable as well."""
    waves = any(isinstance(atom, Call) for _, term in part.parts for atom, _ in term.factors)
    return FORCING if waves else "drift"


def _name_of(acting: frozenset[int], design: Design, state: int) -> str:
    """Return what a product of these variables is called; nothing if powers of a spring say it."""
    if any(one >= len(design.states) for one in acting):
        return "input gain"
    if acting == {design.position_of(state)}:
        return ""
    return "nonlinear damping" if acting == {state} else "coupling"


def drifts(effect: CandidateMaker, design: Design, t: Sum) -> Iterator[Candidate]:
    """Go through what changes with the time: the constant, or what another term is worth.

    What changes already may do so faster and faster, as the pull on a rocket that burns its fuel.
    """
    yield effect("drift", t, parents=(OFFSET,))
    parts = parts_of(design, effect.state)
    still = [part for part in parts if not part.variables & t.variables]
    for part in still:
        yield effect("drift", mul(t, part), parents=(part,))
    for changing in (t, *(mul(t, part) for part in still)):
        if changing in parts:
            yield effect("drift", mul(t, changing), parents=(changing,))


def parts_of(design: Design, state: int) -> list[Sum]:
    """Return what has a coefficient of its own in an equation, but the constant."""
    parts = (column.parts[state] for column in design.columns)
    return [bare(part) for part in parts if part.variables]
