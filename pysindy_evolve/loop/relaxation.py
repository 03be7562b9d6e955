"""Relaxation that an equation may lack: a spring whose force fades, a body that stores heat.

What acts is how far a state is ahead of a hidden one that follows it, see relaxing.py. Short
relaxation times look like a damping, long ones like a spring or an outflow; in between nothing else
of the vocabulary has the same phase, but noise, a filter or a late input can look like it.
"""

from __future__ import annotations

from dataclasses import dataclass

from ..memory import DELAY, LAG
from ..relaxing import relaxing
from ..signals import Record
from ..terms import Sum, variable
from .candidate import Candidate, CandidateMaker, Shape
from .hysteresis import SIMPLER

__all__ = ["relaxed_ways"]

# A shorter one looks like one more derivative of the state, in which noise of the target, and any
# late or lagging input, can be told from the measured state itself.
SHORTEST = 0.5  # relaxation time, in periods of the highest frequency that a filter left
SAMPLES = 2.0  # the same, in samples
LONGEST = 0.25  # of the record
RATIO = 2.5  # between places of the grid, from each of which it is tuned
PLAINER = (*SIMPLER, "viscous damping", DELAY, LAG)


@dataclass(frozen=True)
class Relaxed:
    """Builds the term of a relaxation from its time, which is no shorter than the samples can tell.

    Attributes
    ----------
    source, time : Sum
        The state that a hidden one follows, and the time.
    shortest : float
        Relaxation time, units of t.
    """

    source: Sum
    time: Sum
    shortest: float

    def __call__(self, relaxation_time: float) -> Sum:
        """Return the term."""
        return relaxing(self.source, self.time, max(relaxation_time, self.shortest))


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
    made, value = record.preparation, SAMPLES * record.dt
    if made is not None and made.cutoff:
        value = max(value, SHORTEST / made.cutoff)
    build, found = Relaxed(variable(source), variable(time), value), []
    while value < LONGEST * len(record) * record.dt:
        shape = Shape((value,), (build,))
        found.append(effect("hidden state", shape=shape, refines=PLAINER, alone=True))
        value *= RATIO
    return found
