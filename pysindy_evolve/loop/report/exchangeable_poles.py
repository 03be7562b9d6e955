"""A lag before a linear first-order equation: input and state do not tell which pole is whose."""

from __future__ import annotations

from ...export import format_number
from ...hidden_states.memory import LAG
from ...hidden_states.memory_equations import MemoryEquations
from ...terms import Sum, only_term, variable
from ..facts.outcome import Outcome


def exchangeable_poles(outcome: Outcome) -> list[str]:
    """Name the lags whose time constant can be exchanged with that of the state they act on.

    Parameters
    ----------
    outcome : Outcome
        What the loop found.

    Returns
    -------
    list of str
        Sentences.
    """
    model = outcome.after.model
    if not isinstance(model, MemoryEquations) or model.n_algebraic:
        return []
    lags = [one for one in model.memories if one.kind == LAG]
    users = [(lag, _only_user(model, len(model.inner.states) + lag.column)) for lag in lags]
    return [
        f"The time constant of the lag, {format_number(lag.values[0])}, and that of "
        f"{model.states[place]} itself, {format_number(-1.0 / rate)}, can change places: "
        f"{model.states[place]} then responds to the inputs as before, and only knowledge of the "
        "machine tells which is which."
        for lag, place in users
        if place is not None and (rate := _rate_of(model.inner.sums[place], place)) < 0.0
    ]


def _only_user(model: MemoryEquations, column: int) -> int | None:
    """Return the only state that an input drives, if its equation holds nothing but the two."""
    sides = model.inner.sums
    driven = [place for place, side in enumerate(sides) if column in side.variables]
    alone = len(driven) == 1 and sides[driven[0]].variables <= {driven[0], column}
    return driven[0] if alone else None


def _rate_of(side: Sum, place: int) -> float:
    """Return the coefficient of a state in its own equation; zero if the equation is not linear."""
    itself = only_term(variable(place))
    is_linear = all(term.size == 1 for _, term in side.parts if term.variables)
    return sum(c for c, term in side.parts if term == itself) if is_linear else 0.0
