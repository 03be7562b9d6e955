"""Effects of several equations that are one force, as what rubs in a joint moves both arms."""

from __future__ import annotations

from itertools import combinations
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .effect import Effect
    from .report import LoopReport

__all__ = ["one_force"]


def one_force(report: LoopReport) -> list[str]:
    """Say which effects of two equations enter as the same input, with the same number.

    Parameters
    ----------
    report : LoopReport
        What the loop found.

    Returns
    -------
    list of str
        Sentences.
    """
    return [
        f"{one.name[0].upper()}{one.name[1:]} in the equations of {one.state} and {other.state} "
        f"acts {one.entry} in both, with coefficients that the record cannot tell apart: it is one "
        "force, and moves both."
        for one, other in combinations(report.effects, 2)
        if _is_one(one, other)
    ]


def _is_one(one: Effect, other: Effect) -> bool:
    if not one.entry or (one.entry, one.name) != (other.entry, other.name):
        return False
    (low, high), (lower, higher) = (effect.confidence_intervals[0] for effect in (one, other))
    return bool(one.state != other.state and low <= higher and lower <= high)
