"""Inertia that varies periodically with a position, as of a crank or an unbalanced arm.

By Lagrange's equations, M(q) v' + M'(q) v^2 / 2 is the sum of all forces. In units of its mean,
M = 1 + a cos(n q) + b sin(n q).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ...operators import BUILTIN
from ...terms import Sum, add, call, constant, div, mul, power, sub, variable


@dataclass(frozen=True)
class InertiaWave:
    """One wave of an inertia.

    Attributes
    ----------
    position, velocity : int
        The variables that it depends on, and whose equation it changes.
    number : float
        Wave number n, radians per unit of the position.
    function : str
        "cos" or "sin".
    """

    position: int
    velocity: int
    number: float
    function: str

    @property
    def wave(self) -> Sum:
        """What it adds to the inertia."""
        return self._wave(self.function)

    @property
    def centrifugal(self) -> Sum:
        """What it adds to the forces: minus half of its slope, times the squared velocity."""
        slope = mul(constant(0.5 * self.number), power(variable(self.velocity), 2))
        if self.function == "cos":
            return mul(slope, self._wave("sin"))
        return mul(slope, mul(constant(-1.0), self._wave("cos")))

    def lacking(self, rate: Sum) -> Sum:
        """Return what a model of constant inertia, with the acceleration `rate`, lacks."""
        return sub(self.centrifugal, mul(self.wave, rate))

    def _wave(self, function: str) -> Sum:
        angle = mul(constant(self.number), variable(self.position))
        return call(BUILTIN[function], angle)


def over_inertia(forces: Sum, waves: Sequence[tuple[float, InertiaWave]]) -> Sum:
    """Return the acceleration that forces give to an inertia of one plus some waves.

    Parameters
    ----------
    forces : Sum
        In the unit of the mean inertia.
    waves : sequence of (float, InertiaWave)
        Each with its amplitude, in the same unit.

    Returns
    -------
    Sum
    """
    inertia = constant(1.0)
    for amplitude, one in waves:
        inertia = add(inertia, mul(constant(amplitude), one.wave))
        forces = add(forces, mul(constant(amplitude), one.centrifugal))
    return div(forces, inertia)
