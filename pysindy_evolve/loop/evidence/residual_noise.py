"""The noise at each frequency, from what all columns together leave there.

Of few segments, the lowest frequencies hold fewer numbers than there are columns that are slow, and
next to nothing is left there, whatever the noise. So what is left is divided by how many numbers
the columns left free (the residual degrees of freedom: the trace of one minus the hat matrix), and
averaged over as many neighbors as it takes to have enough of them.
"""

from __future__ import annotations

import numpy as np

from ...checks import TINY

__all__ = ["free_numbers", "noise_power"]

ENOUGH = 16.0  # free numbers to know the noise at a frequency by
ALIKE = 1e-9  # share of the largest direction, below which columns are alike
LEAST_POWER = 1e-8  # of the noise, relative to its peak: below it there is only rounding


def free_numbers(columns: np.ndarray) -> np.ndarray:
    """Return how many of the numbers at each frequency least squares with some columns leaves free.

    Parameters
    ----------
    columns : ndarray of complex of shape (n_columns, n_segments, n_frequencies)
        Of one equation, weighed as they are fitted.

    Returns
    -------
    ndarray of shape (n_frequencies,)
        The number of segments where the columns take none.
    """
    n_columns, *shape = columns.shape
    flat = np.ascontiguousarray(columns.reshape(n_columns, np.prod(shape))).view(float)
    size = np.linalg.norm(flat, axis=1, keepdims=True)
    flat = flat / np.maximum(size, TINY)
    sizes, directions = np.linalg.eigh(flat @ flat.T)
    kept = sizes > ALIKE * np.max(sizes, initial=0.0)
    basis = (directions[:, kept] / np.sqrt(sizes[kept])).T @ flat
    taken = np.sum(basis**2, axis=0).reshape(*shape, 2)
    return np.asarray(np.maximum(np.sum(1.0 - taken.mean(axis=2), axis=0), 0.0))


def noise_power(left: np.ndarray, free: np.ndarray) -> np.ndarray:
    """Return the power of the noise at each frequency of one equation, (n_frequencies,).

    Parameters
    ----------
    left : ndarray of complex of shape (n_segments, n_frequencies)
        What the fit leaves.
    free : ndarray of shape (n_frequencies,)
        Numbers that it left free.

    Returns
    -------
    ndarray of shape (n_frequencies,)
        The mean over an eighth of an octave around each frequency, and more where that is needed.
    """
    n = len(free)
    reach = 1 + np.arange(n) // 8
    while np.any(few := (_around(free, reach) < ENOUGH) & (reach < n)):
        reach[few] += 1
    power = np.sum(np.abs(left) ** 2, axis=0)
    mean = _around(power, reach) / np.maximum(_around(free, reach), TINY)
    return np.maximum(mean, np.max(mean) * LEAST_POWER + TINY)


def _around(values: np.ndarray, reach: np.ndarray) -> np.ndarray:
    """Return the sums of values over so many places before and after each."""
    n = len(values)
    sums, place = np.append(0.0, np.cumsum(values)), np.arange(n)
    return np.asarray(sums[np.minimum(place + reach + 1, n)] - sums[np.maximum(place - reach, 0)])
