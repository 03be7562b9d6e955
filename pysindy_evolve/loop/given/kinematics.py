"""Which states are positions, and which are their velocities, read off the equations."""

from __future__ import annotations

from ...equations import Equations
from ...terms import Variable

__all__ = ["positions"]


def positions(equations: Equations) -> dict[int, int]:
    """Return the position of each state that is the derivative of another one.

    Parameters
    ----------
    equations : Equations
        The model; a position is a state whose whole right-hand side is one other state.

    Returns
    -------
    dict of int to int
        Column of the velocity to column of the position.
    """
    found = {}
    for state, side in enumerate(equations.sums):
        if len(side.parts) != 1 or side.parts[0][0] != 1.0:
            continue
        factors = side.parts[0][1].factors
        if len(factors) == 1 and isinstance(factors[0][0], Variable) and factors[0][1] == 1:
            index = factors[0][0].index
            if index < len(equations.states) and index != state:
                found[index] = state
    return found
