r"""Weights that make the rows of a trajectory white: sensor noise, and a random force, integrated.

The readings of a record are disturbed by e + D w, where e is white, w is a random force that
forgets exponentially, some at once, and D integrates it. With V = I + ratio D C D^T, where C holds
the correlations of w, least squares weighed by its inverse are generalized ones (Aitken 1936,
DOI 10.1017/S0370164600014346). A start, which nobody knows, is taken off first.

======  ==============================================  ======================================
symbol  shape                                           meaning
======  ==============================================  ======================================
ratio   scalar                                          variance of the drift D w, over that of e
memory  scalar                                          of w, in lengths of the record
starts  (n, order)                                      what the unknown first state adds
axes    (n_memories, n, n)                              of D C D^T, which all ratios share
scales  (n_noises, n)                                   that make the rows along them white
fitted  (n_noises, n, order)                            orthonormal: the starts, made white
======  ==============================================  ======================================
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.polynomial import legendre
from scipy.linalg import cholesky, toeplitz

__all__ = ["NOISES", "Noise", "Whitening", "drift_size", "whitening"]


class Noise(NamedTuple):
    """How strong a force is against the noise of the sensor, and how long it lasts."""

    ratio: float
    memory: float


RATIOS = np.geomspace(1e-2, 1e6, 13)  # from hardly any force to nothing else
MEMORIES = (0.0, 0.05, 0.15)  # a force that lasts longer is taken for an effect
NOISES = (Noise(0.0, 0.0), *(Noise(float(r), m) for m in MEMORIES for r in RATIOS))
OF_MEMORY = np.array([MEMORIES.index(noise.memory) for noise in NOISES])


@dataclass(frozen=True, eq=False)
class Whitening:
    """How rows are weighed for each noise, and the log determinants of the restricted likelihood.

    Symbols as above.
    """

    axes: np.ndarray
    scales: np.ndarray
    fitted: np.ndarray
    logdets: np.ndarray

    def grams(self, rows: np.ndarray) -> np.ndarray:
        """Return inner products of columns of shape (n, p), free of starts: (n_noises, p, p)."""
        along = np.swapaxes(self.axes, 1, 2) @ rows
        white = self.scales[:, :, None] * along[OF_MEMORY]
        starts = np.swapaxes(self.fitted, 1, 2) @ white
        return np.asarray(np.swapaxes(white, 1, 2) @ white - np.swapaxes(starts, 1, 2) @ starts)


@lru_cache(maxsize=32)
def whitening(n: int, order: int) -> Whitening:
    """Return how n rows are weighed whose disturbing force is integrated `order` times."""
    starts, axes, spreads = _starts(n, order), [], []
    for memory in MEMORIES:
        drift = _drift(n, order, memory) / drift_size(n, order, memory)
        left, sizes, _ = np.linalg.svd(drift)
        axes.append(left)
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
    """Return the RMS drift of n rows by a force of unit variance, the best start taken off.

    For a sampling time of one; it is proportional to its power `order`.
    """
    drift = _drift(n, order, memory)
    basis, _ = np.linalg.qr(_starts(n, order))
    return float(np.sqrt(np.sum((drift - basis @ (basis.T @ drift)) ** 2) / n))


@lru_cache(maxsize=64)
def _drift(n: int, order: int, memory: float) -> np.ndarray:
    """Return what makes a drift of independent numbers."""
    integral = np.linalg.matrix_power(np.tril(np.ones((n, n))), order)
    if memory == 0.0:
        return integral
    return integral @ cholesky(toeplitz(np.exp(-np.arange(n) / (memory * n))), lower=True)


def _starts(n: int, order: int) -> np.ndarray:
    return legendre.legvander(np.linspace(-1.0, 1.0, n), order - 1)
