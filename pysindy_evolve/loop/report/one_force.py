"""Effects in several equations that are one force: friction in a joint moves both arms."""

from __future__ import annotations

from itertools import combinations

from ..facts.effect import Effect
from ..facts.outcome import Outcome


def one_force(outcome: Outcome) -> list[str]:
    """Name the effects that act like the same input in two equations, with the same coefficient.

    Parameters
    ----------
    outcome : Outcome
        What the loop found.

    Returns
    -------
    list of str
        Sentences.
    """
    return [
        f"{first.name[0].upper()}{first.name[1:]} in the equations of {first.state} and "
        f"{second.state} acts {first.entry}, with coefficients that the record cannot tell apart: "
        "it is one force that acts in both equations."
        for first, second in combinations(outcome.effects, 2)
        if _is_same_force(first, second)
    ]


def _is_same_force(first: Effect, second: Effect) -> bool:
    """Tell whether two effects share name and entry, and their intervals overlap."""
    if not first.entry or (first.entry, first.name) != (second.entry, second.name):
        return False
    (low, high), (lower, higher) = (effect.confidence_intervals[0] for effect in (first, second))
    return bool(first.state != second.state and low <= higher and lower <= high)
