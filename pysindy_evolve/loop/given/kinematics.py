"""Which states are positions, and which are velocities: by the equations, and by the records."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...checks import TINY
from ...equations import Equations
from ...signals import Record, choose_windows, project
from ...terms import Sum, Variable


def whole_state(side: Sum, state: int, n_states: int) -> int | None:
    """Return the other state that is the whole of a right-hand side, as v is in q' = v, or None.

    Parameters
    ----------
    side : Sum
        Right-hand side.
    state : int
        The state whose rate it is.
    n_states : int
        Number of states, the first variables.

    Returns
    -------
    int or None
    """
    if len(side.parts) != 1 or side.parts[0][0] != 1.0:
        return None
    factors = side.parts[0][1].factors
    if len(factors) != 1 or not isinstance(factors[0][0], Variable) or factors[0][1] != 1:
        return None
    index = factors[0][0].index
    return index if index < n_states and index != state else None


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
        other = whole_state(side, state, len(equations.states))
        if other is not None:
            found[other] = state
    return found


def disagreement(records: Sequence[Record], position: int, velocity: int) -> float:
    """Return by how much the rate of a position differs from its declared velocity.

    Both are averaged over windows, since sensor noise makes them differ from row to row.

    Parameters
    ----------
    records : sequence of Record
        Training records.
    position, velocity : int
        Columns of the states.

    Returns
    -------
    float
        RMS of the difference, over the standard deviation of the rate.
    """
    windows = choose_windows(list(records))
    long = [r for r in records if r.n_samples >= windows.width]
    rates = [project(r.x_dot[:, [position]], windows) for r in long]
    misses = [project(r.x_dot[:, [position]] - r.x[:, [velocity]], windows) for r in long]
    if not long:
        return 0.0
    spread = float(np.concatenate(rates).std())
    return float(np.sqrt(np.mean(np.concatenate(misses) ** 2))) / max(spread, TINY)
