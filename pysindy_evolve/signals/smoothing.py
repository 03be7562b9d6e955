r"""States with less noise, estimated with the help of their derivatives.

The states x and the derivatives x_dot measure one signal, as x_dot is the slope of x. So noisy
states are estimated from both, see `wiener`. A regression on the estimate has no
errors-in-variables bias, as the remaining error is not correlated with it. Values that the estimate
does not improve, see `improved`, stay as they were measured.

References
----------
Carroll et al., Measurement Error in Nonlinear Models, 2006, chapter 4 (regression calibration).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .improved import improved
from .spectral import Array
from .time_step import time_step
from .wiener import MAX_QUIET_NOISE, estimate

N_PROBES, PROBE_ROWS = 8, 512  # number and rows of the stretches that are checked for noise
LEAST_ROWS = 256  # fewer rows do not give a usable spectrum


@dataclass(frozen=True, eq=False)
class Smoothed:
    """Columns of one trajectory with less noise.

    Attributes
    ----------
    x : ndarray of shape (n_samples, n_columns)
        States and inputs, in the user's units.
    noise : ndarray of shape (n_columns,)
        Standard deviation of the noise that remains in the improved values of each.
    measured_noise : ndarray of shape (n_columns,)
        Standard deviation of the noise in the other values.
    improved : ndarray of bool of shape (n_samples, n_columns)
        False for values that are as they were measured.
    ends : int
        Rows at each end where the estimate is worse, if there is any.
    """

    x: Array
    noise: Array
    measured_noise: Array
    improved: NDArray[np.bool_]
    ends: int

    @property
    def noise_of_values(self) -> Array:
        """Standard deviation of the noise in each value of x."""
        return np.where(self.improved, self.noise, self.measured_noise)


def is_noisy(x: Array) -> bool:
    """Tell whether a column of x (n, k), in order of time, has white noise that does harm.

    Differences of sixth order remove a well-sampled signal; their median over the rows ignores
    jumps. The cost is that of a few thousand rows.
    """
    return bool(np.any(_roughness(x) > MAX_QUIET_NOISE))


def _roughness(x: Array) -> Array:
    """Return the noise of each column by sixth differences, as a share of its RMS."""
    starts = np.linspace(0, max(len(x) - PROBE_ROWS, 0), N_PROBES).astype(int)
    probes = [x[a : a + PROBE_ROWS] for a in dict.fromkeys(starts.tolist())]
    differences = np.concatenate([np.abs(np.diff(part, n=6, axis=0)) for part in probes])
    rms = np.sqrt(np.mean([np.mean(np.square(part), axis=0) for part in probes], axis=0))
    # Sixth differences of unit white noise have variance 924; the median of |normal| is 0.6745.
    noise = np.median(differences, axis=0) / (0.6745 * np.sqrt(924.0))
    return np.asarray(noise / np.where(rms > 0.0, rms, 1.0))


def smooth_states(x: Array, x_dot: Array) -> Smoothed | None:
    """Estimate states and inputs from noisy measurements of them and of the derivatives.

    Parameters
    ----------
    x : ndarray of shape (n_samples, n_states + n_inputs)
        One trajectory, rows in order of time and evenly sampled.
    x_dot : ndarray of shape (n_samples, n_states)
        Derivatives of the first columns of x.

    Returns
    -------
    Smoothed or None
        None if no noise does harm, or if the rows are no uniform time series.

    Notes
    -----
    The cost is a few FFTs of 2 n samples for each column.
    """
    n_states = x_dot.shape[1]
    if len(x) < LEAST_ROWS or not is_noisy(x):
        return None
    dt = time_step(x[:, :n_states], x_dot)
    if dt is None:
        return None
    smooth, noise, ends = x.copy(), np.zeros(x.shape[1]), 0
    for columns in _chains(x, x_dot):
        last_column = columns[-1]
        levels = [x[:, j] for j in columns]
        levels += [x_dot[:, last_column]] if last_column < n_states else []
        scaled = np.column_stack([level * dt**m for m, level in enumerate(levels)])
        estimated, noise_left, its_ends = estimate(scaled)
        ends = max(ends, its_ends)
        for m, j in enumerate(columns):
            smooth[:, j], noise[j] = estimated[:, m] / dt**m, noise_left[m] / dt**m
    trusted, measured_noise = improved(x, smooth)
    return Smoothed(np.where(trusted, smooth, x), noise, measured_noise, trusted, ends)


def _chains(x: Array, x_dot: Array) -> list[list[int]]:
    """Group columns of x into chains: each column is the derivative of the one before, by x_dot."""
    n_states = x_dot.shape[1]
    derivative_of = {
        i: j
        for i in range(n_states)
        for j in range(n_states)
        if i != j and np.array_equal(x_dot[:, i], x[:, j])
    }
    chains, free = [], set(range(x.shape[1]))
    firsts = [j for j in range(x.shape[1]) if j not in derivative_of.values()]
    for first in [*firsts, *range(x.shape[1])]:
        chain: list[int] = []
        column: int | None = first
        while column is not None and column in free:
            free.remove(column)
            chain.append(column)
            column = derivative_of.get(column)
        if chain:
            chains.append(chain)
    return chains
