"""A lag before a linear first-order equation: no record tells which of two poles is whose."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...export import format_number
from ...hidden_states.memory import LAG
from ...hidden_states.memory_equations import MemoryEquations
from ...terms import Sum, only_term, variable

if TYPE_CHECKING:
    from .report import LoopReport

__all__ = ["exchangeable_poles"]


def exchangeable_poles(report: LoopReport) -> list[str]:
    """Say which lags can change places with the time constant of the state that they act on.

    Parameters
    ----------
    report : LoopReport
        What the loop found.

    Returns
    -------
    list of str
        Sentences.
    """
    model = report.after.model
    if not isinstance(model, MemoryEquations) or model.n_algebraic:
        return []
    lags = [one for one in model.memories if one.kind == LAG]
    places = [(lag, _only_user(model, len(model.inner.states) + lag.column)) for lag in lags]
    return [
        f"The time constant of the lag, {format_number(lag.values[0])}, and that of "
        f"{model.states[place]} itself, {format_number(-1.0 / rate)}, can change places: the "
        f"inputs move {model.states[place]} as before then, and only what is known of the machine "
        "tells which is which."
        for lag, place in places
        if place is not None and (rate := _rate_of(model.inner.sums[place], place)) < 0.0
    ]


def _only_user(model: MemoryEquations, column: int) -> int | None:
    """Return the state on which alone an input acts, and nothing else beside it; None if none."""
    sides = model.inner.sums
    users = [place for place, side in enumerate(sides) if column in side.variables]
    alone = len(users) == 1 and sides[users[0]].variables <= {users[0], column}
    return users[0] if alone else None


def _rate_of(side: Sum, place: int) -> float:
    """Return the coefficient of a state in its own equation; zero if that is not linear."""
    own = only_term(variable(place))
    is_linear = all(term.size == 1 for _, term in side.parts if term.variables)
    return sum(c for c, term in side.parts if term == own) if is_linear else 0.0
