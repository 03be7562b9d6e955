"""Rows to grow terms on: what was measured, freed from noise where it does harm.

Noise in the regressors biases least squares and makes up terms. Three things cure it. The states
are smoothed by what their derivatives say (`signals.smoothing`), so what is left of the noise is
small and no longer goes with the regressors. Terms are evaluated on those states and compared with
the measured target, so nothing is smoothed that was not measured smooth. And rows where a variable
is so close to zero that its sign is a coin toss are left out, if an operator has a kink there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ..operators import Operator
from ..signals.smoothing import Smoothed, smooth_states

__all__ = ["Rows", "denoise"]

UNSURE = 6.0  # standard deviations of the noise left: nearer to zero, a sign is a coin toss
ENOUGH = 0.2  # share of the rows that must stay; of a column that is mostly at zero all do
STEP = 1e-6  # beside zero, to tell a kink


@dataclass(frozen=True, eq=False)
class Rows:
    """Joined trajectories as terms see them.

    Attributes
    ----------
    x : ndarray of shape (n_samples, n_columns)
        States and inputs.
    kept : ndarray of bool of shape (n_samples,), or None
        Rows that say something about the equations; None is all of them.
    noise : ndarray of shape (n_columns,), or None
        Standard deviation of the noise that is left in each column; None if nothing was done.
    """

    x: np.ndarray
    kept: np.ndarray | None = None
    noise: np.ndarray | None = None

    def of(self, columns: np.ndarray) -> np.ndarray:
        """Return the kept rows of columns."""
        return columns if self.kept is None else columns[self.kept]


def denoise(
    x: np.ndarray, x_dot: np.ndarray, lengths: Sequence[int], operators: Sequence[Operator]
) -> Rows:
    """Free trajectories from noise in their states and inputs.

    Parameters
    ----------
    x : ndarray of shape (n_samples, n_states + n_inputs)
        States and inputs of all trajectories.
    x_dot : ndarray of shape (n_samples, n_states)
        Derivatives of the states.
    lengths : sequence of int
        Rows of each trajectory.
    operators : sequence of Operator
        Basis functions of the search.

    Returns
    -------
    Rows
        As they were given, where there is no noise or where rows are no time series.
    """
    if x_dot.shape[1] > x.shape[1]:
        return Rows(x)
    ends = np.cumsum([0, *lengths])
    parts = [slice(int(a), int(b)) for a, b in pairwise(ends)]
    found = [smooth_states(x[part], x_dot[part]) for part in parts]
    if all(smoothed is None for smoothed in found):
        return Rows(x)
    kinks = any(map(_has_kink, operators))
    smooth, kept = x.copy(), np.ones(len(x), dtype=bool)
    for part, smoothed in zip(parts, found, strict=True):
        if smoothed is not None:
            smooth[part] = smoothed.x
            kept[part] = _sure(smoothed) if kinks else True
            kept[part][: smoothed.ends] = kept[part][len(smoothed.x) - smoothed.ends :] = False
    squares = [np.zeros(x.shape[1]) if f is None else len(f.x) * f.noise**2 for f in found]
    return Rows(smooth, kept, np.sqrt(np.sum(squares, axis=0) / len(x)))


def _sure(smoothed: Smoothed) -> np.ndarray:
    """Tell where no variable is too close to zero for its sign to be known."""
    sure = np.ones(len(smoothed.x), dtype=bool)
    for column, noise in zip(smoothed.x.T, smoothed.noise, strict=True):
        clear = np.abs(column) > UNSURE * noise
        if column.min() < 0.0 < column.max() and np.mean(clear & sure) >= ENOUGH:
            sure &= clear
    return sure


def _has_kink(operator: Operator) -> bool:
    """Tell whether a function of one variable has a jump or a corner at zero."""
    if operator.arity != 1:
        return False
    with np.errstate(all="ignore"):
        below, at, above = operator.function(np.array([-STEP, 0.0, STEP]))
    return bool(abs(above - below) > 0.1 or abs(above + below - 2.0 * at) > 0.1 * STEP)
