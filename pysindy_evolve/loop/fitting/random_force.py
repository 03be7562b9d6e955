r"""Weights that make the rows of a trajectory white: sensor noise, and a random force, integrated.

The readings of a record are disturbed by e + D w, where e is white sensor noise, w is a random
force, white or with exponential correlation, and D integrates it. Generalized least squares (Aitken
1936, DOI 10.1017/S0370164600014346) weighs the rows by the inverse of V = I + ratio D C D^T, where
C is the correlation matrix of w. The unknown start of a record is projected out first.

======  ==============================================  ======================================
symbol  shape                                           meaning
======  ==============================================  ======================================
ratio   scalar                                          variance of the drift D w, over that of e
memory  scalar                                          correlation time of w, in record lengths
starts  (n, order)                                      what the unknown first state adds
axes    (n_memories, n, n)                              eigenvectors of D C D^T
scales  (n_noises, n)                                   factors that whiten rows along the axes
fitted  (n_noises, n, order)                            orthonormal basis of whitened starts
======  ==============================================  ======================================
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.polynomial import legendre
from scipy.linalg import cholesky, toeplitz


class Noise(NamedTuple):
    """Strength of a random force relative to sensor noise, and its correlation time."""

    ratio: float
    memory: float


RATIOS = np.geomspace(1e-2, 1e6, 13)  # from hardly any force to hardly any sensor noise
MEMORIES = (0.0, 0.05, 0.15)  # a force that lasts longer is taken for an effect
NOISES = (Noise(0.0, 0.0), *(Noise(float(r), m) for m in MEMORIES for r in RATIOS))
OF_MEMORY = np.array([MEMORIES.index(noise.memory) for noise in NOISES])


@dataclass(frozen=True, eq=False)
class Whitening:
    """Weights of rows for each noise, and log determinants of the restricted likelihood.

    Symbols as above.
    """

    axes: np.ndarray
    scales: np.ndarray
    fitted: np.ndarray
    logdets: np.ndarray

    def grams(self, rows: np.ndarray) -> np.ndarray:
        """Return inner products of columns (n, p), starts projected out: (n_noises, p, p)."""
        along = np.swapaxes(self.axes, 1, 2) @ rows
        white = self.scales[:, :, None] * along[OF_MEMORY]
        starts = np.swapaxes(self.fitted, 1, 2) @ white
        return np.asarray(np.swapaxes(white, 1, 2) @ white - np.swapaxes(starts, 1, 2) @ starts)


@lru_cache(maxsize=32)
def whitening(n: int, order: int) -> Whitening:
    """Return the weights of n rows for a disturbing force that is integrated `order` times."""
    starts, axes, spreads = _starts(n, order), [], []
    for memory in MEMORIES:
        drift = _drift(n, order, memory) / drift_size(n, order, memory)
        vectors, sizes, _ = np.linalg.svd(drift)
        axes.append(vectors)
        spreads.append(sizes**2)
    ratios = np.array([noise.ratio for noise in NOISES])
    variances = 1.0 + ratios[:, None] * np.array(spreads)[OF_MEMORY]
    scales = 1.0 / np.sqrt(variances)
    along = np.swapaxes(np.array(axes), 1, 2) @ starts
    fitted, upper = np.linalg.qr(scales[:, :, None] * along[OF_MEMORY])
    corners = np.abs(np.diagonal(upper, axis1=1, axis2=2))
    logdets = np.log(variances).sum(axis=1) + 2.0 * np.log(corners).sum(axis=1)
    return Whitening(np.array(axes), scales, fitted, logdets)


@lru_cache(maxsize=64)
def drift_size(n: int, order: int, memory: float) -> float:
    """Return the RMS drift of n rows by a force of unit variance, the best start projected out.

    It holds for a sampling time of one, and grows as dt ** order.
    """
    drift = _drift(n, order, memory)
    basis, _ = np.linalg.qr(_starts(n, order))
    return float(np.sqrt(np.sum((drift - basis @ (basis.T @ drift)) ** 2) / n))


@lru_cache(maxsize=64)
def _drift(n: int, order: int, memory: float) -> np.ndarray:
    """Return the matrix that turns independent numbers of unit variance into a drift."""
    integral = np.linalg.matrix_power(np.tril(np.ones((n, n))), order)
    if memory == 0.0:
        return integral
    return integral @ cholesky(toeplitz(np.exp(-np.arange(n) / (memory * n))), lower=True)


def _starts(n: int, order: int) -> np.ndarray:
    return legendre.legvander(np.linspace(-1.0, 1.0, n), order - 1)
