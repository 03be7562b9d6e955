"""Inputs that act through a function of them, such as a thrust that goes as the square of a speed.

Where an input jumps, the mean of its square over a time is not the square of its mean, and so it is
with a low-pass. What reaches the machine is the function; so this is what is averaged and filtered,
and the record holds the input that has such a function.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from .spectral import Array

__all__ = ["InputFunction"]

MARGINS = (0.5, 0.1)  # of the range of an input, by which a low-pass may pass its ends
N_POINTS = 2049  # of a table, between which the inverse is a straight line
ROUNDING = 1e-12  # of its largest value, that a function varies by where it is constant
JUMP = 0.01  # of the range of values, that lie between two points of a table if nothing jumps


@dataclass(frozen=True, eq=False)
class InputFunction:
    """A function of one input through which it acts, and its inverse.

    Parameters
    ----------
    function : callable
        From values of the input, (n,), to what acts, (n,).
    low, high : float
        Range of the input.
    """

    function: Callable[[Array], Array]
    low: float
    high: float

    @property
    def is_invertible(self) -> bool:
        """Whether it turns nowhere, unless at an input of zero, and does not jump."""
        return bool(self._sides)

    def covering(self, u: Array) -> InputFunction:
        """Return the same function over a range that holds these values as well."""
        low, high = min(self.low, float(u.min())), max(self.high, float(u.max()))
        return self if (low, high) == (self.low, self.high) else replace(self, low=low, high=high)

    def after(self, change: Callable[[Array], Array], u: Array, plain: Array) -> Array:
        """Return the input whose function is the changed function of another input.

        Parameters
        ----------
        change : callable
            A linear operation, such as a low-pass, from (n,) to (m,).
        u : ndarray of shape (n,)
            The input.
        plain : ndarray of shape (m,)
            The changed input itself, which tells its sign.

        Returns
        -------
        ndarray of shape (m,)
        """
        values = change(np.asarray(self.function(u)))
        found = [np.interp(values, f, inputs) for inputs, f in self._sides]
        return found[0] if len(found) == 1 else np.where(plain < 0.0, *found)

    @cached_property
    def _sides(self) -> list[tuple[Array, Array]]:
        """Return inputs and values that rise, over the whole range or below and above zero.

        Where the function turns close to the range, it is followed less far beyond.
        """
        for margin in MARGINS:
            beyond = margin * (self.high - self.low)
            low, high = self.low - beyond, self.high + beyond
            below = [(low, 0.0)] * (self.low < 0.0)
            for ranges in ([(low, high)], [*below, *[(0.0, high)] * (self.high > 0.0)]):
                sides = [side for one in ranges if (side := self._table(*one)) is not None]
                if len(sides) == len(ranges):
                    return sides
        return []

    def _table(self, low: float, high: float) -> tuple[Array, Array] | None:
        """Return inputs and values that rise; None where the function turns, or has no values."""
        inputs = np.linspace(low, high, N_POINTS)
        with np.errstate(all="ignore"):
            values = np.asarray(self.function(inputs), dtype=float)
        has_value = np.isfinite(values)
        inputs, values = inputs[has_value], values[has_value]
        if not inputs.size or inputs[0] > max(self.low, low) or inputs[-1] < min(self.high, high):
            return None
        if values[-1] < values[0]:
            inputs, values = inputs[::-1], values[::-1]
        rises, least = np.diff(values), ROUNDING * np.abs(values).max()
        if np.any(rises < -least) or np.all(rises <= least):
            return None
        rising = np.append(True, rises > least)  # of a plateau, where it begins
        inputs, values = inputs[rising], values[rising]
        return (inputs, values) if self._reaches(inputs, values) else None

    def _reaches(self, inputs: Array, values: Array) -> bool:
        """Tell whether it takes the values between those of a table as well, and does not jump."""
        between = [0.5 * (side[1:] + side[:-1]) for side in (inputs, values)]
        with np.errstate(all="ignore"):
            missed = np.abs(self.function(between[0]) - between[1]).max()
        return bool(missed <= JUMP * np.ptp(values))
