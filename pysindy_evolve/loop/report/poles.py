"""A lag before a linear first-order equation: no record tells which of two poles is whose."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...export import format_number
from ...hidden_states.hidden import MemoryEquations
from ...hidden_states.memory import LAG
from ...terms import Sum, variable

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
    model, said = report.after.model, []
    if not isinstance(model, MemoryEquations) or model.n_algebraic:
        return []
    lags = {one.state: one for one in report.effects if one.name == LAG}
    for state, lag in lags.items():
        place = model.states.index(state)
        rate = _rate_of(model.inner.sums[place], place)
        if rate < 0.0:
            said.append(
                f"The time constant of the lag, {format_number(float(lag.coefficients[0]))}, and "
                f"that of {state} itself, {format_number(-1.0 / rate)}, can change places: the "
                f"inputs move {state} as before then, and only what is known of the machine tells "
                "which is whose."
            )
    return said


def _rate_of(side: Sum, place: int) -> float:
    """Return the coefficient of a state in its own equation; zero if that is not linear in it."""
    ((_, own),) = variable(place).parts
    is_linear = all(term.size == 1 for _, term in side.parts if term.variables)
    return sum(c for c, term in side.parts if term == own) if is_linear else 0.0
