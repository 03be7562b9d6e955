"""Effects in several equations that are one: friction in a joint moves both arms."""

from __future__ import annotations

from itertools import combinations

from ...export import format_expression
from ..effects.names import VISCOUS_DAMPING
from ..facts.effect import Effect
from ..facts.outcome import Outcome
from .printed_names import OF_ANY_STATE

LOSSES = {VISCOUS_DAMPING, OF_ANY_STATE[VISCOUS_DAMPING]}


def one_force(outcome: Outcome) -> list[str]:
    """Name effects that act like one input in two equations, and terms that have two names.

    Parameters
    ----------
    outcome : Outcome
        What the loop found.

    Returns
    -------
    list of str
        Sentences.
    """
    pairs = list(combinations(outcome.effects, 2))
    told = [
        f"{first.name[0].upper()}{first.name[1:]} in the equations of {first.state} and "
        f"{second.state} acts {first.entry}, with coefficients that the record cannot tell apart: "
        "it is one force that acts in both equations."
        for first, second in pairs
        if _is_same_force(first, second)
    ]
    return told + [
        f"{first.name[0].upper()}{first.name[1:]} in the equation of {first.state} and "
        f"{second.name} in that of {second.state} are the same term, "
        f"{format_expression(first.term)}. Its name depends on the equation that it enters."
        for first, second in pairs
        if _is_same_term(first, second)
    ]


def _is_same_term(first: Effect, second: Effect) -> bool:
    """Tell whether two effects have one term and two names, each in an equation of its own."""
    has_two_names = first.name != second.name and first.state != second.state
    is_term = not (first.quantities or second.quantities)
    is_loss = {first.name, second.name} & LOSSES  # a state couples to others and damps itself
    return has_two_names and is_term and not is_loss and first.expressions == second.expressions


def _is_same_force(first: Effect, second: Effect) -> bool:
    """Tell whether two effects share name and entry, and their intervals overlap."""
    if not first.entry or (first.entry, first.name) != (second.entry, second.name):
        return False
    (low, high), (lower, higher) = (effect.confidence_intervals[0] for effect in (first, second))
    return bool(first.state != second.state and low <= higher and lower <= high)
