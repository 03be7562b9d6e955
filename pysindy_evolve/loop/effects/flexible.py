"""Masses that an equation of motion may lack: nobody measured them, and they swing.

What acts is what such a mass pulls with, see flexible_mode.py. Far below its own frequency it is
one more mass, far above it a spring; in between nothing else of the vocabulary has the same phase.
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

__all__ = ["flexible_ways", "within_band"]

FEWEST_PERIODS = 16.0  # of a record
HIGHEST = 0.5  # frequency, in those up to which a filter leaves what there is ...
FASTEST = 0.1  # ... and in samplings: a filter may look like one that is higher
RATIO = 1.25  # between frequencies of the grid, from each of which it is tuned
DAMPING = 0.1  # ratio, before it is tuned: wide enough to be felt at the next frequency
CLEAR = 1.1  # times by which a frequency must lie within the range
NUMBERS = ("angular frequency", "damping ratio")


@dataclass(frozen=True)
class Flexible:
    """Builds the term of a hidden mass from its angular frequency and its damping ratio.

    Attributes
    ----------
    x, v, time : Sum
        Position and velocity of the measured mass, and the time.
    fastest : float
        Angular frequency, radians per unit of t; no higher one can be told.
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
        None where nothing drives the motion: two frequencies and how fast each dies away are four
        numbers, and two masses have five.
    """
    if record.u is None:
        return []
    effect, time = CandidateMaker(state), record.n_states + record.n_inputs
    frequency, fastest = _band(record)
    places = variable(position), variable(state), variable(time)
    build, found = Flexible(*places, fastest), []
    while frequency < fastest:
        shape = Shape((frequency, DAMPING), (build,), meanings=NUMBERS, branch=1)
        own = effect(HIDDEN_STATE, shape=shape, must_beat=PLAINER, never_paired=True, passive=True)
        found.append(own)
        frequency *= RATIO
    return found


def within_band(path: Call, record: Record) -> bool:
    """Tell whether the frequency of a hidden mass lies clearly within those that are tried."""
    (frequency, _), (low, high) = kind_of(path).numbers(path), _band(record)
    return CLEAR * low < frequency < high / CLEAR


def _band(record: Record) -> tuple[float, float]:
    """Return the lowest and the highest angular frequency that a record can tell."""
    made, highest = record.preparation or record.motion, FASTEST / record.dt
    if made is not None and made.cutoff:
        highest = min(highest, HIGHEST * made.cutoff)
    return 2 * np.pi * FEWEST_PERIODS / (len(record) * record.dt), 2 * np.pi * highest
