"""Flows and forces that depend on a difference, with one coefficient instead of two.

Examples are heat between two walls, current between two nodes, the loss of a tank to the room.
Where an equation has a coefficient for one part of the difference already, the other part alone
says as much.

Between first-order states, flows may also be nonlinear: a turbulent one through a valve goes with
the root of the difference, a draft with its square, radiation with fourth powers. What a measured
flow carries, such as the air of a fan, goes with flow times difference. And a declared force by a
difference may saturate at a grip.
"""

from __future__ import annotations

from collections.abc import Iterator

from ...operators import BUILTIN
from ...terms import Call, Sum, call, mul, only_term, power, sub, variable
from ..given.design import Design
from ..given.ranges import Ranges
from .candidate import Candidate, CandidateMaker, bare
from .names import COUPLING
from .slips import gripping


def differences(
    effect: CandidateMaker, design: Design, state: int, other: int, ranges: Ranges
) -> Iterator[Candidate]:
    """Yield what the difference of two positions, or of two states of one kind, does."""
    position, is_position = design.position_of(state), design.derivative_of(other) is not None
    own = state if position is None or not is_position else position
    same_kind = (is_position or design.position_of(other) is not None) == (position is not None)
    if same_kind:  # a current is not compared with an angle
        yield from _difference(effect, design, own, other)
        if position is None:
            yield from _flows(effect, own, other)
            yield from _carried(effect, design, own, other)
            yield from _gripping(effect, design, own, other, ranges)


def gripping_stretches(design: Design, ranges: Ranges) -> list[Candidate]:
    """Return forces that level off with a declared stretch between two bodies, as of a clutch.

    Beside a declared spring, a gap between the bodies does much the same to the derivative. So they
    are no candidates of a look: free runs have to tell them from what a look has found.

    Parameters
    ----------
    design : Design
        The model.
    ranges : Ranges
        Ranges of the variables.

    Returns
    -------
    list of Candidate
    """
    places = [(s, design.position_of(s)) for s in design.open_states]
    pairs = [(s, own, other) for s, own in places for _, other in places if own != other]
    return [
        one
        for state, own, other in pairs
        if own is not None and other is not None
        for one in _gripping(CandidateMaker(state), design, own, other, ranges)
    ]


def _gripping(
    effect: CandidateMaker, design: Design, own: int, other: int, ranges: Ranges
) -> Iterator[Candidate]:
    """Yield forces that level off with a difference that the equation declares."""
    if any(_holds_difference(side, own, other) for side in design.sides_of(effect.state)):
        slip = sub(variable(other), variable(own))
        yield from gripping(effect, COUPLING, slip, float(ranges.apart[own, other]))


def losses(effect: CandidateMaker, design: Design, column: int) -> Iterator[Candidate]:
    """Yield what a first-order state loses to its surroundings, measured as an input.

    An input that acts on the state already is a source, and not the surroundings.
    """
    if not any(column in side.variables for side in design.sides_of(effect.state)):
        yield from _difference(effect, design, effect.state, column)
        yield from _flows(effect, effect.state, column)
        yield from _carried(effect, design, effect.state, column)


def radiated(effect: CandidateMaker, design: Design, ranges: Ranges) -> Iterator[Candidate]:
    """Yield radiation where heat is declared to flow: differences of fourth powers.

    Both temperatures must always be above zero, as those in kelvin are.
    """
    own, sides = effect.state, design.sides_of(effect.state)
    above = [v for v in range(design.time) if ranges.stays_positive(v)]
    for other in above if own in above else []:
        if other != own and any(_holds_difference(side, own, other) for side in sides):
            yield effect(COUPLING, sub(power(variable(other), 4), power(variable(own), 4)))


def _flows(effect: CandidateMaker, own: int, other: int) -> Iterator[Candidate]:
    """Yield flows by a power of a difference, toward the lower one.

    The root is that of an orifice, the square that of a resistance, and the power 1.5 that of a
    slot or of rising warm air.
    """
    head = sub(variable(other), variable(own))
    size = call(BUILTIN["abs"], head)
    yield effect(COUPLING, mul(call(BUILTIN["sgn"], head), call(BUILTIN["sqrt"], size)))
    yield effect(COUPLING, mul(head, call(BUILTIN["sqrt"], size)))
    yield effect(COUPLING, mul(head, size))


def _carried(effect: CandidateMaker, design: Design, own: int, other: int) -> Iterator[Candidate]:
    """Yield what a measured flow carries in: flow times difference."""
    head = sub(variable(other), variable(own))
    for flow in range(len(design.states), design.time):
        if flow != other:
            yield effect(COUPLING, mul(variable(flow), head), never_paired=True)


def _difference(
    effect: CandidateMaker, design: Design, own: int, other: int
) -> Iterator[Candidate]:
    """Yield the coupling by a difference, unless one of its parts has its own coefficient."""
    fitted = {bare(c.parts[effect.state]) for c in design.columns if c.parts[effect.state].parts}
    if not fitted & {variable(own), variable(other)}:
        yield effect(COUPLING, sub(variable(other), variable(own)))


def acting_differences(design: Design, state: int) -> Iterator[tuple[int, int]]:
    """Yield the states that may act relative to an input: a speed in the wind, a stretch.

    The equation declares their difference, or the input acts nowhere: somebody measured it for a
    reason.

    Parameters
    ----------
    design : Design
        The model.
    state : int
        Whose equation.

    Yields
    ------
    own, other : int
        The state itself or its position, and the input.
    """
    position = design.position_of(state)
    possible = [state] if position is None else [state, position]
    first = len(design.states)
    used = {v for k in range(first) for side in design.sides_of(k) for v in side.variables}
    for own in possible:
        for other in range(first, first + len(design.inputs)):
            sides = design.sides_of(state)
            if other not in used or any(_holds_difference(side, own, other) for side in sides):
                yield own, other


def _holds_difference(side: Sum, own: int, other: int) -> bool:
    """Tell whether two variables enter a side, or a function in it, with opposite coefficients."""
    weights = {term: c for c, term in side.parts}
    one, two = only_term(variable(own)), only_term(variable(other))
    if weights.get(one, 0.0) != 0.0 and weights.get(one) == -weights.get(two, 0.0):
        return True
    atoms = (atom for _, term in side.parts for atom, _ in term.factors)
    inside = (each for atom in atoms if isinstance(atom, Call) for each in atom.args)
    return any(_holds_difference(each, own, other) for each in inside)
