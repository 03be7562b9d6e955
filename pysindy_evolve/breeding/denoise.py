"""Rows to grow terms on: the measured rows, denoised where noise would do harm.

Noise in the regressors biases least squares and makes up terms. Three steps prevent that. The
states are smoothed with the help of their derivatives (`signals.smoothing`), so that the remaining
noise is small and hardly correlated with the regressors. Terms are evaluated on the smoothed states
and compared with the measured target; neither is smoothed itself. If an operator has a kink at
zero, rows where a variable is too close to zero for its sign to be known are left out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ..operators import Operator
from ..signals.smoothing import Smoothed, smooth_states

UNSURE = 6.0  # standard deviations of the remaining noise; closer to zero, the sign is not known
# Least share of the rows to keep; a column that would leave fewer removes none.
MIN_KEPT_SHARE = 0.2
KINK_STEP = 1e-6  # step to both sides of zero, to detect a kink


@dataclass(frozen=True, eq=False)
class Rows:
    """Joined trajectories to evaluate terms on.

    Attributes
    ----------
    x : ndarray of shape (n_samples, n_columns)
        States and inputs.
    kept : ndarray of bool of shape (n_samples,), or None
        Rows to fit on; None means all.
    noise : ndarray of shape (n_samples, n_columns), or None
        Standard deviation of the remaining noise in each value; None if nothing was smoothed.
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
    """Remove noise from the states and inputs of trajectories.

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
        Unchanged where there is no noise or the rows are not a time series.
    """
    if x_dot.shape[1] > x.shape[1]:
        return Rows(x)
    ends = np.cumsum([0, *lengths])
    parts = [slice(int(a), int(b)) for a, b in pairwise(ends)]
    found = [smooth_states(x[part], x_dot[part]) for part in parts]
    if all(smoothed is None for smoothed in found):
        return Rows(x)
    kinks = any(map(_has_kink, operators))
    smooth, noise, kept = x.copy(), np.zeros(x.shape), np.ones(len(x), dtype=bool)
    for part, smoothed in zip(parts, found, strict=True):
        if smoothed is not None:
            smooth[part], noise[part] = smoothed.x, smoothed.noise_of_values
            kept[part] = _needed(smoothed) & (_sure(smoothed) if kinks else True)
    return Rows(smooth, kept, noise)


def _needed(smoothed: Smoothed) -> np.ndarray:
    """Tell which rows tell more of the equations than their noise does harm.

    They are those that were improved well, and of the others those in states that these do not
    reach, such as a transient.
    """
    improved: np.ndarray = np.all(smoothed.improved, axis=1)
    improved[: smoothed.ends] = False
    improved[len(improved) - smoothed.ends :] = False
    if not improved.any():
        return ~improved
    x, reached = smoothed.x, smoothed.x[improved]
    beyond = (x < reached.min(axis=0)) | (x > reached.max(axis=0))
    return np.asarray(improved | beyond.any(axis=1))


def _sure(smoothed: Smoothed) -> np.ndarray:
    """Tell on which rows the sign of the variables is known, see `UNSURE` and `MIN_KEPT_SHARE`."""
    sure = np.ones(len(smoothed.x), dtype=bool)
    for column, noise in zip(smoothed.x.T, smoothed.noise_of_values.T, strict=True):
        clear = np.abs(column) > UNSURE * noise
        if column.min() < 0.0 < column.max() and np.mean(clear & sure) >= MIN_KEPT_SHARE:
            sure &= clear
    return sure


def _has_kink(operator: Operator) -> bool:
    """Tell whether a function of one variable has a jump or a corner at zero."""
    if operator.arity != 1:
        return False
    with np.errstate(all="ignore"):
        below, at, above = operator.function(np.array([-KINK_STEP, 0.0, KINK_STEP]))
    return bool(abs(above - below) > 0.1 or abs(above + below - 2.0 * at) > 0.1 * KINK_STEP)
