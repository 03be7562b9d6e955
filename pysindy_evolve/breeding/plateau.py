"""When a search may stop: it stagnates, or its residual is only noise.

A search stops after `patience` generations without a new term. It stops sooner where the residual
is noise by a test that needs no equation: rows with almost equal variables have unrelated
residuals. The test costs one search for nearest neighbors on a sample, whatever the number of rows.

References
----------
Stefansson, Koncar, Jones, A note on the gamma test, Neural Computing & Applications 5 (1997),
doi:10.1007/BF01413858: neighbors estimate the noise that no smooth model can explain.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from scipy.spatial import KDTree

from ..sparse.parsimony import PERFECT
from ..terms import Product
from .dictionary import Problem
from .generation import Generation

PATIENCE_IF_DONE = 2  # generations to wait for a shorter form once only noise or rounding is left
MAX_ROWS = 10_000  # with ten neighbors each, 1 % of the residual's power is two standard errors
SHARP = 0.005  # largest standard error of the test; too few rows give a larger one
N_NEIGHBORS = 10
# Least share of the fitted values; below it, neighbors are too far apart to judge.
MIN_FITTED_SHARE = 0.9
CHANCE = 2.0  # standard errors; a residual with no larger share is taken for noise


class Plateau:
    """Tells when a search may stop.

    Parameters
    ----------
    problem : Problem
        All rows.
    patience : int
        Generations without a new term in the best equation after which the search ends anyway.
    """

    def __init__(self, problem: Problem, patience: int) -> None:
        self.problem = problem
        self.patience = patience
        self._seen: set[Product] = set()
        self._stale = 0
        self._judged: dict[frozenset[Product], bool] = {}

    def reached(self, generation: Generation) -> bool:
        """Record a generation and tell whether the search ends with it.

        Notes
        -----
        A term is new if no best equation held it before, with any inner constants: an equation
        that comes and goes from sample to sample is not new. A perfect equation of one variable
        ends the search at once, as nothing is shorter.
        """
        shapes = frozenset(term.skeleton for term in generation.terms)
        self._stale = self._stale + 1 if shapes <= self._seen else 0
        self._seen |= shapes
        if generation.error <= PERFECT:
            size = sum(term.size for term in generation.terms)
            return size <= 1 or self._stale >= min(self.patience, PATIENCE_IF_DONE)
        if self._stale >= self.patience:
            return True
        return self._stale >= PATIENCE_IF_DONE and self._leaves_noise(generation, shapes)

    def _leaves_noise(self, generation: Generation, shapes: frozenset[Product]) -> bool:
        if self.problem.project is not None:
            return False  # a projected row mixes many samples, so it has no neighbors
        if shapes not in self._judged:
            sample, neighbors = self._sample
            theta, y = sample.regression(generation.terms)
            basis = np.linalg.qr(theta)[0]
            fitted = basis @ (basis.T @ y)
            of_fit, _ = share_common_to_neighbors(fitted - fitted.mean(), neighbors)
            of_rest, error = share_common_to_neighbors(y - fitted, neighbors)
            self._judged[shapes] = (
                of_fit >= MIN_FITTED_SHARE and error <= SHARP and of_rest <= CHANCE * error
            )
        return self._judged[shapes]

    @cached_property
    def _sample(self) -> tuple[Problem, np.ndarray]:
        sample = self.problem.sample(MAX_ROWS, np.random.default_rng(0))
        size = sample.x.std(axis=0)
        points = sample.x / np.where(size > 0.0, size, 1.0)
        n_neighbors = min(N_NEIGHBORS, len(points) - 1)
        _, neighbors = KDTree(points).query(points, n_neighbors + 1)
        return sample, neighbors[:, 1:]


def share_common_to_neighbors(values: np.ndarray, neighbors: np.ndarray) -> tuple[float, float]:
    """Measure how much of a signal neighbors have in common.

    Parameters
    ----------
    values : ndarray of shape (n,)
        A signal without mean.
    neighbors : ndarray of int of shape (n, k)
        Rows that are near each row.

    Returns
    -------
    share : float
        Share of the signal's power that neighbors have in common: 1 if they are equal, about 0
        for noise (dimensionless).
    error : float
        Standard error of the share if the signal is noise, whose size may vary from row to row.
    """
    power = float(values @ values)
    if power == 0.0:
        return 0.0, 0.0
    near = values[neighbors]
    share = float(values @ near.mean(axis=1)) / power
    # A pair of mutual neighbors counts twice, hence the factor 2.
    error = np.sqrt(2.0 * float(np.square(values) @ np.square(near).sum(axis=1)))
    return share, error / (neighbors.shape[1] * power)
