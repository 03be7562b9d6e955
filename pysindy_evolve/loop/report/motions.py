"""Imagined motions: the recorded one with another amplitude, or at other frequencies."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ...equations import Equations
from ..given.kinematics import positions

FACTORS = (1.0, 1.5, 2.0, 3.0, 5.0)  # of amplitudes and frequencies; and their inverses
# Few machines do more than this times the amplitude, speed or acceleration of a good record.
LARGEST_FACTOR = 5.0


@dataclass(frozen=True)
class Motion:
    """The recorded motion with its amplitude and its frequencies multiplied."""

    amplitude: float
    frequency: float

    @property
    def is_within_reach(self) -> bool:
        """Whether amplitude, speed and acceleration grow by no more than `LARGEST_FACTOR`."""
        grown = max(self.amplitude * self.frequency**order for order in range(3))
        return grown <= LARGEST_FACTOR * (1.0 + 1e-9)

    @property
    def effort(self) -> float:
        """Distance from the recorded motion: log factors, and a surcharge for changing both."""
        larger, faster = abs(np.log(self.amplitude)), abs(np.log(self.frequency))
        return float(larger + faster + 0.5 * min(larger, faster))


class Motions:
    """Motions that can be derived from a record.

    Parameters
    ----------
    equations : Equations
        The model: says which states are velocities.
    z : ndarray of shape (..., n_variables)
        States, inputs and time as recorded.
    """

    def __init__(self, equations: Equations, z: np.ndarray) -> None:
        self.speeds = tuple(positions(equations))
        flat = z.reshape(-1, z.shape[-1])
        low, high = flat.min(axis=0), flat.max(axis=0)
        self.keeps_sign = (low > 0.0) | (high < 0.0)
        # A variable that never changes its sign, such as a level, is scaled about its mean.
        self.center = np.where(self.keeps_sign, flat.mean(axis=0), 0.0)
        self.z = z

    def __iter__(self) -> Iterator[Motion]:
        """Yield motions within reach of a machine, the closest to the recorded one first."""
        factors = {*FACTORS, *(1.0 / factor for factor in FACTORS)}
        imagined = [Motion(a, f) for a in factors for f in (factors if self.speeds else {1.0})]
        motions = [motion for motion in imagined if motion.is_within_reach]
        return iter(sorted(motions, key=lambda motion: (motion.effort, -motion.amplitude)))

    def of(self, motion: Motion) -> np.ndarray | None:
        """Return states, inputs and time in a motion, of the shape of z.

        None if a variable that keeps its sign in the record would change it.
        """
        factors = np.full(self.z.shape[-1], motion.amplitude)
        factors[list(self.speeds)] *= motion.frequency
        factors[-1] = 1.0
        moved = self.center + factors * (self.z - self.center)
        kept = self.keeps_sign.copy()
        kept[-1] = False
        signs = np.sign(self.center[kept])
        if np.any(moved[..., kept] * signs <= 0.0):
            return None
        return moved
