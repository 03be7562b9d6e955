"""Inertia that changes with the position, as an effect that a model of a constant one lacks."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import partial

import numpy as np

from ...terms import Sum
from ..given.inertia import InertiaWave
from ..given.ranges import Ranges
from .candidate import Candidate, Shape
from .names import INERTIA
from .periodic import WAVE_NUMBER

FUNCTIONS = ("cos", "sin")
WAVE_NUMBER_REACH_IN_LOG = 0.2  # how far the logarithm of a wave number is tuned: about 20 %


@dataclass(frozen=True)
class InertiaCandidate(Candidate):
    """Two waves of an inertia, whose coefficients are their amplitudes.

    Its terms contain the acceleration by the model, as last fitted.
    """

    position: int = field(kw_only=True)

    @property
    def size(self) -> int:
        """Number of nodes that have a price: the forces are known."""
        return self.n_columns

    @property
    def waves(self) -> tuple[InertiaWave, ...]:
        """What each of its columns adds to the inertia."""
        number = self.shape.values[0] if self.shape is not None else 0.0
        return tuple(InertiaWave(self.position, self.state, number, one) for one in FUNCTIONS)


def inertias(
    state: int, position: int, rate: Sum, ranges: Ranges, inputs: range
) -> list[InertiaCandidate]:
    """Return inertias that vary once or twice a turn, for a swing of a quarter turn each way.

    Only a measured force tells an inertia from other forces of the position: without an input in
    the equation there are none.
    """
    turns = 2.0 * ranges.swing_of(position) >= np.pi
    if not (turns and rate.variables & set(inputs)):
        return []
    return [
        inertia_candidate(state, position, rate, float(n), WAVE_NUMBER_REACH_IN_LOG, branch=n)
        for n in (1, 2)
    ]


def inertia_candidate(
    state: int, position: int, rate: Sum, number: float, reach: float, branch: int = 0
) -> InertiaCandidate:
    """Return the candidate of an inertia that goes up and down with a position.

    Parameters
    ----------
    state, position : int
        Velocity, in whose equation it stands, and its position.
    rate : Sum
        The acceleration by the model.
    number : float
        Wave number, radians per unit of the position.
    reach : float
        How far its logarithm may be tuned to both sides.
    branch : int
        Tells it from others of its equation.

    Returns
    -------
    InertiaCandidate
    """
    builds = tuple(partial(_lacking, one, position, state, rate) for one in FUNCTIONS)
    shape = Shape((number,), builds, reach, (WAVE_NUMBER,), branch)
    return InertiaCandidate(
        INERTIA, state, shape.terms, shape=shape, never_paired=True, position=position
    )


def _lacking(function: str, position: int, velocity: int, rate: Sum, number: float) -> Sum:
    return InertiaWave(position, velocity, number, function).lacking(rate)
