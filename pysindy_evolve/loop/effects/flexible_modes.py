"""Unmeasured masses on springs, which an equation of motion may lack.

The term is the pull of such a mass, see flexible_mode.py. Far below its own frequency it acts as
more mass, far above as a spring; in between no other effect of the vocabulary has the same phase.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...hidden_states.flexible_mode import DAMPINGS, flexible_mode
from ...hidden_states.path_states import kind_of
from ...signals import Record
from ...terms import Call, Sum, variable
from .candidate import Candidate, CandidateMaker, Shape
from .names import HIDDEN_STATE
from .relaxation import PLAINER

FEWEST_PERIODS = 16.0  # of the lowest frequency, in a record
MAX_CUTOFF_SHARE = 0.5  # highest frequency, as a share of the cutoff of a filter ...
MAX_SAMPLING_RATE_SHARE = 0.1  # ... and of the sampling rate: a filter may look like a higher one
RATIO = 1.25  # between frequencies of the grid, from each of which it is tuned
DAMPING = 0.1  # ratio before tuning: wide enough to show at the next frequency of the grid
MIN_RATIO_TO_ENDS = 1.1  # factor by which a frequency must keep away from the ends of its range
NUMBERS = ("angular frequency", "damping ratio")


@dataclass(frozen=True)
class Flexible:
    """Builds the term of a hidden mass from its angular frequency and its damping ratio.

    Attributes
    ----------
    x, v, time : Sum
        Position and velocity of the measured mass, and the time.
    fastest : float
        Highest angular frequency that a record can tell, radians per unit of t.
    """

    x: Sum
    v: Sum
    time: Sum
    fastest: float

    def __call__(self, frequency: float, damping: float) -> Sum:
        """Return the term."""
        low, high = DAMPINGS
        numbers = min(frequency, self.fastest), min(max(damping, low), high)
        return flexible_mode(self.x, self.v, self.time, *numbers)


def flexible_ways(state: int, position: int, record: Record) -> list[Candidate]:
    """Return the hidden masses that an equation of motion may lack.

    Parameters
    ----------
    state, position : int
        Velocity and position of the measured mass.
    record : Record
        The longest of the training records.

    Returns
    -------
    list of Candidate
        Empty where nothing drives the motion: a free decay shows two frequencies and two decay
        rates, which are four numbers, and two masses have five.
    """
    if record.u is None:
        return []
    effect, time = CandidateMaker(state), record.n_states + record.n_inputs
    frequency, fastest = _band(record)
    places = variable(position), variable(state), variable(time)
    build, found = Flexible(*places, fastest), []
    while frequency < fastest:
        shape = Shape((frequency, DAMPING), (build,), meanings=NUMBERS, branch=1)
        candidate = effect(
            HIDDEN_STATE, shape=shape, must_beat=PLAINER, never_paired=True, passive=True
        )
        found.append(candidate)
        frequency *= RATIO
    return found


def within_band(path: Call, record: Record) -> bool:
    """Tell whether the frequency of a hidden mass lies clearly within the range tried."""
    (frequency, _), (low, high) = kind_of(path).numbers(path), _band(record)
    return MIN_RATIO_TO_ENDS * low < frequency < high / MIN_RATIO_TO_ENDS


def _band(record: Record) -> tuple[float, float]:
    """Return the lowest and the highest angular frequency that a record can tell."""
    made, highest = record.preparation or record.motion, MAX_SAMPLING_RATE_SHARE / record.dt
    if made is not None and made.cutoff:
        highest = min(highest, MAX_CUTOFF_SHARE * made.cutoff)
    return 2 * np.pi * FEWEST_PERIODS / (len(record) * record.dt), 2 * np.pi * highest
