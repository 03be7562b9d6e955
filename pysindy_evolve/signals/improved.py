r"""Rows on which an estimate of a signal is nearer to it than its measurement.

One filter serves a whole record, as if its motion were alike from start to end. Where it is not,
as in a transient of a few rows, and next to the ends, the filter smooths away motion too. What it
took away, the measurement less the estimate, should be noise alone. White noise takes no side:
neighboring rows of it are uncorrelated. An error of the estimate does, so the
local covariance of neighboring rows is the square of that error.

========  ======  ===============================================================
symbol    shape   meaning
========  ======  ===============================================================
removed   (n, k)  measurement less estimate
error     (n, k)  covariance of neighboring rows of it, less its usual one
noise     (k,)    usual mean square of it
freedom   (k,)    independent rows in a window
========  ======  ===============================================================
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d
from scipy.stats import chi2

from .spectral import Array

WINDOW = 64  # rows of a local mean
# Of a larger mean square of noise alone. For white noise this is twice the usual mean square: the
# measurement is taken where the estimate is further from the signal than the noise is.
CHANCE = 1e-6


def improved(measured: Array, estimated: Array) -> tuple[NDArray[np.bool_], Array]:
    """Tell where an estimate may be trusted, and how large the noise is where it may not.

    Parameters
    ----------
    measured, estimated : ndarray of shape (n_samples, n_columns)
        Rows in order of time.

    Returns
    -------
    trusted : ndarray of bool of shape (n_samples, n_columns)
    noise : ndarray of shape (n_columns,)
        Standard deviation of the noise of the measurement.
    """
    removed = measured - estimated
    noise = np.median(uniform_filter1d(removed**2, WINDOW, axis=0), axis=0)
    pairs = removed[1:] * removed[:-1]
    covariance = uniform_filter1d(np.vstack([pairs, pairs[-1:]]), WINDOW, axis=0)
    usual = np.median(covariance, axis=0)
    correlation = np.clip(usual / np.where(noise > 0.0, noise, 1.0), 0.0, 1.0)
    # The mean square of noise that is correlated from row to row scatters more.
    freedom = WINDOW * (1.0 - correlation**2) / (1.0 + correlation**2)
    freedom = np.maximum(freedom, 1.0)
    largest = noise * (chi2.isf(CHANCE, freedom) / freedom - 1.0)
    return covariance - usual <= largest, np.sqrt(noise)
