"""Relaxation that an equation may lack: a spring whose force fades, a body that stores heat.

What acts is how far a state is ahead of a hidden one that follows it, see relaxing.py. Short
relaxation times look like a damping, long ones like a spring or an outflow; in between nothing else
of the vocabulary has the same phase, but noise, a filter or a late input can look like it.
"""

from __future__ import annotations

from functools import partial

from ..memory import DELAY, LAG
from ..relaxing import relaxing
from ..signals import Record
from ..terms import variable
from .candidate import Candidate, CandidateMaker, Shape
from .hysteresis import SIMPLER

__all__ = ["relaxed_ways"]

SHORTEST = 4.0  # relaxation time, in samples
LONGEST = 0.25  # of the record
RATIO = 2.5  # between places of the grid, from each of which it is tuned
PLAINER = (*SIMPLER, "viscous damping", DELAY, LAG)


def relaxed_ways(state: int, source: int, record: Record) -> list[Candidate]:
    """Return the relaxations that an equation may lack.

    Parameters
    ----------
    state : int
        Whose equation it is.
    source : int
        The state that a hidden one follows: a position, or the state itself.
    record : Record
        The longest of the training records.

    Returns
    -------
    list of Candidate
    """
    effect, time = CandidateMaker(state), record.n_states + record.n_inputs
    build = partial(relaxing, variable(source), variable(time))
    found, value = [], SHORTEST * record.dt
    while value < LONGEST * len(record) * record.dt:
        found.append(effect("hidden state", shape=Shape((value,), (build,)), refines=PLAINER))
        value *= RATIO
    return found
