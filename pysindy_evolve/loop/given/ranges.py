"""Ranges of variables, which decide what effects they can have."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class Ranges:
    """Ranges of states, inputs and time, in their units.

    Attributes
    ----------
    largest : ndarray of shape (n_variables,)
        Largest magnitudes.
    signed : ndarray of bool of shape (n_variables,)
        Which of them change their sign.
    apart : ndarray of shape (n_variables, n_variables)
        Largest magnitude of the difference of each two.
    middle : ndarray of shape (n_variables,)
        Halfway between the smallest and the largest value.
    """

    largest: np.ndarray
    signed: np.ndarray
    apart: np.ndarray
    middle: np.ndarray

    def swing_of(self, variable: int) -> float:
        """Return how far a variable goes to each side of its middle."""
        return float(self.largest[variable] - abs(self.middle[variable]))

    def smallest(self, variable: int) -> float:
        """Return the smallest magnitude of a variable that keeps its sign."""
        return float(2.0 * abs(self.middle[variable]) - self.largest[variable])

    def stays_positive(self, variable: int) -> bool:
        """Tell whether a variable is above zero in all rows."""
        return bool(2.0 * self.middle[variable] > self.largest[variable])

    @classmethod
    def of(cls, variables: np.ndarray) -> Ranges:
        """Return the ranges of rows of variables, (n_samples, n_variables)."""
        low, high = variables.min(axis=0), variables.max(axis=0)
        largest, signed = np.maximum(np.abs(low), np.abs(high)), (low < 0.0) & (high > 0.0)
        apart = [np.abs(variables - column[:, None]).max(axis=0) for column in variables.T]
        return cls(largest, signed, np.array(apart), 0.5 * (low + high))

    @classmethod
    def about_zero(cls, largest: np.ndarray) -> Ranges:
        """Return ranges symmetric about zero, for the largest magnitudes (n_variables,)."""
        both = np.ones(largest.shape, dtype=bool)
        return cls(largest, both, np.add.outer(largest, largest), np.zeros_like(largest))
