"""Inputs that act through a function, such as a thrust proportional to the square of a speed.

Where an input jumps, the mean of its square is not the square of its mean, and the same holds for a
low-pass. The function is what reaches the machine. So it is the function that is averaged and
filtered, and the record holds the input that has the result as its function.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from .spectral import Array

# Shares of an input's range by which a low-pass may exceed it; the second if the first fails.
OVERSHOOTS = (0.5, 0.1)
N_POINTS = 2049  # points of a table, linear in between
# Share of the largest value; a function that varies less counts as constant.
MIN_RELATIVE_RISE = 1e-12
TABLE_ERROR = 0.01  # share of the range of values; a larger error between points means a jump


@dataclass(frozen=True, eq=False)
class InputFunction:
    """A function of one input through which it acts, and its inverse.

    Parameters
    ----------
    function : callable
        From values of the input, (n,), to the values that act, (n,).
    low, high : float
        Range of the input.
    """

    function: Callable[[Array], Array]
    low: float
    high: float

    @property
    def is_invertible(self) -> bool:
        """Whether it is continuous and monotonic, or so on each side of zero."""
        return bool(self._branches)

    def covering(self, u: Array) -> InputFunction:
        """Return the same function over a range that includes these values of the input."""
        low, high = min(self.low, float(u.min())), max(self.high, float(u.max()))
        return self if (low, high) == (self.low, self.high) else replace(self, low=low, high=high)

    def after(self, change: Callable[[Array], Array], u: Array, plain: Array) -> Array:
        """Apply a linear operation to the function of an input, and invert the function.

        Parameters
        ----------
        change : callable
            A linear operation, such as a low-pass, from (n,) to (m,).
        u : ndarray of shape (n,)
            The input.
        plain : ndarray of shape (m,)
            The operation on the input itself, which gives the sign of the result.

        Returns
        -------
        ndarray of shape (m,)
            The input that has the changed values as its function.
        """
        values = change(np.asarray(self.function(u)))
        found = [np.interp(values, outputs, inputs) for inputs, outputs in self._branches]
        return found[0] if len(found) == 1 else np.where(plain < 0.0, *found)

    @cached_property
    def _branches(self) -> list[tuple[Array, Array]]:
        """Return tables of the inverse: one for the whole range, or one below and one above zero.

        Empty if there are none. Where the function turns shortly beyond the range, the tables
        extend less far.
        """
        for overshoot in OVERSHOOTS:
            excess = overshoot * (self.high - self.low)
            low, high = self.low - excess, self.high + excess
            below = [(low, 0.0)] * (self.low < 0.0)
            for ranges in ([(low, high)], [*below, *[(0.0, high)] * (self.high > 0.0)]):
                tables = [table for branch in ranges if (table := self._table(*branch)) is not None]
                if len(tables) == len(ranges):
                    return tables
        return []

    def _table(self, low: float, high: float) -> tuple[Array, Array] | None:
        """Return inputs and values in the order of rising values.

        None if the function is not monotonic, not continuous, or has no values on a part of the
        range.
        """
        inputs = np.linspace(low, high, N_POINTS)
        with np.errstate(all="ignore"):
            values = np.asarray(self.function(inputs), dtype=float)
        has_value = np.isfinite(values)
        inputs, values = inputs[has_value], values[has_value]
        if not inputs.size or inputs[0] > max(self.low, low) or inputs[-1] < min(self.high, high):
            return None
        if values[-1] < values[0]:
            inputs, values = inputs[::-1], values[::-1]
        rises, flat = np.diff(values), MIN_RELATIVE_RISE * np.abs(values).max()
        if np.any(rises < -flat) or np.all(rises <= flat):
            return None
        keep = np.append(True, rises > flat)  # a plateau is represented by its first point
        inputs, values = inputs[keep], values[keep]
        return (inputs, values) if self._is_continuous(inputs, values) else None

    def _is_continuous(self, inputs: Array, values: Array) -> bool:
        """Tell whether the function meets its table between the points too, and so has no jump."""
        midpoints = [0.5 * (column[1:] + column[:-1]) for column in (inputs, values)]
        with np.errstate(all="ignore"):
            error = np.abs(self.function(midpoints[0]) - midpoints[1]).max()
        return bool(error <= TABLE_ERROR * np.ptp(values))
