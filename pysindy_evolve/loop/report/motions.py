"""Imagined motions: the recorded one with another amplitude, or at other frequencies."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ...equations import Equations
from ..given.kinematics import positions

AMPLITUDES = (1.0, 1.5, 2.0, 3.0, 5.0, 10.0)  # and their inverses
FREQUENCIES = (1.0, 1.5, 2.0, 3.0, 5.0)


@dataclass(frozen=True)
class Motion:
    """The recorded motion with its amplitude and its frequencies multiplied."""

    amplitude: float
    frequency: float

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
        """Yield motions, the closest to the recorded one first."""
        amplitudes = {*AMPLITUDES, *(1.0 / a for a in AMPLITUDES)}
        frequencies = {*FREQUENCIES, *(1.0 / f for f in FREQUENCIES)} if self.speeds else {1.0}
        motions = [Motion(a, f) for a in amplitudes for f in frequencies]
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
