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
weights (n_noises, n, n)                                inner products of rows, free of starts
======  ==============================================  ======================================
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.polynomial import legendre
from scipy.linalg import cholesky, solve_triangular, toeplitz

__all__ = ["NOISES", "Noise", "Whitening", "drift_size", "whitening"]


class Noise(NamedTuple):
    """How strong a force is against the noise of the sensor, and how long it lasts."""

    ratio: float
    memory: float


RATIOS = np.geomspace(1e-2, 1e6, 13)  # from hardly any force to nothing else
MEMORIES = (0.0, 0.05, 0.15)  # a force that lasts longer is taken for an effect
NOISES = (Noise(0.0, 0.0), *(Noise(float(r), m) for m in MEMORIES for r in RATIOS))


@dataclass(frozen=True, eq=False)
class Whitening:
    """Weights of the rows for each noise, and the log determinants of the restricted likelihood."""

    weights: np.ndarray
    logdets: np.ndarray


@lru_cache(maxsize=32)
def whitening(n: int, order: int) -> Whitening:
    """Return how n rows are weighed whose disturbing force is integrated `order` times."""
    starts = _starts(n, order)
    weights, logdets = [], []
    for noise in NOISES:
        drift = _drift(n, order, noise.memory) / drift_size(n, order, noise.memory)
        root = cholesky(np.eye(n) + noise.ratio * drift @ drift.T, lower=True)
        white = solve_triangular(root, np.eye(n), lower=True)
        basis, upper = np.linalg.qr(white @ starts)
        white -= basis @ (basis.T @ white)
        weights.append(white.T @ white)
        diagonals = np.concatenate([np.diagonal(root), np.diagonal(upper)])
        logdets.append(2.0 * np.log(np.abs(diagonals)).sum())
    return Whitening(np.array(weights), np.array(logdets))


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
