"""Relaxation that an equation may lack: a spring whose force fades, a body that stores heat.

The term is how far a state is ahead of a hidden one that follows it, see relaxing.py. Short
relaxation times look like a damping, long ones like a spring or an outflow. In between no other
effect of the vocabulary has the same phase, but noise, a filter or a late input can look like it.
"""

from __future__ import annotations

from dataclasses import dataclass

from ...hidden_states.memory import DELAY, LAG
from ...hidden_states.path_states import kind_of
from ...hidden_states.relaxing import relaxing
from ...signals import Record
from ...terms import Call, Sum, variable
from .candidate import Candidate, CandidateMaker, Shape
from .hysteresis import SIMPLER
from .names import HIDDEN_STATE, VISCOUS_DAMPING

# A shorter one looks like one more derivative of the state, which also explains noise of the target
# and any late or lagging input.
MIN_TIME_IN_PERIODS = 0.5  # relaxation time, in periods of the highest frequency that a filter left
MIN_TIME_IN_SAMPLES = 2.0  # and in samples
MAX_TIME_SHARE = 0.125  # relaxation time, as a share of the record
MIN_TIME_RATIO = 1.25  # least relaxation time, over the shortest one tried
RATIO = 2.5  # between places of the grid, from each of which it is tuned
PLAINER = (*SIMPLER, VISCOUS_DAMPING, DELAY, LAG)


@dataclass(frozen=True)
class Relaxed:
    """Builds the term of a relaxation from its time, which is no shorter than the samples can tell.

    Attributes
    ----------
    source, time : Sum
        The state that a hidden one follows, and the time.
    shortest : float
        Shortest relaxation time, units of t.
    """

    source: Sum
    time: Sum
    shortest: float

    def __call__(self, relaxation_time: float) -> Sum:
        """Return the term."""
        return relaxing(self.source, self.time, max(relaxation_time, self.shortest))


def relaxed_ways(
    state: int, source: int, record: Record, *, passive: bool = True
) -> list[Candidate]:
    """Return the relaxations that an equation may lack.

    Parameters
    ----------
    state : int
        Whose equation it is.
    source : int
        The state that a hidden one follows: a position, or the state itself.
    record : Record
        The longest of the training records.
    passive : bool
        Whether it can only take energy, as in an equation of motion.

    Returns
    -------
    list of Candidate
    """
    effect, time = CandidateMaker(state), record.n_states + record.n_inputs
    value, longest = _span(record)
    build, found = Relaxed(variable(source), variable(time), value), []
    while value < longest:
        shape = Shape((value,), (build,), meanings=("relaxation time",))
        candidate = effect(
            HIDDEN_STATE, shape=shape, must_beat=PLAINER, never_paired=True, passive=passive
        )
        found.append(candidate)
        value *= RATIO
    return found


def longest_relaxation(record: Record) -> float:
    """Return the longest relaxation time that is looked for in a record."""
    return _span(record)[1]


def _span(record: Record) -> tuple[float, float]:
    """Return the shortest and the longest relaxation time that a record can tell."""
    made, shortest = record.preparation or record.motion, MIN_TIME_IN_SAMPLES * record.dt
    if made is not None and made.cutoff:
        shortest = max(shortest, MIN_TIME_IN_PERIODS / made.cutoff)
    return shortest, MAX_TIME_SHARE * len(record) * record.dt


def within_reach(path: Call, record: Record) -> bool:
    """Tell whether a relaxation time is clearly longer than the shortest, and not too long.

    If tuning ends at the shortest, it would go further if it could: what is missing is another
    derivative.
    """
    (relaxation_time,), (shortest, longest) = kind_of(path).numbers(path), _span(record)
    return MIN_TIME_RATIO * shortest < relaxation_time < longest
