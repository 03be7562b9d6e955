"""When a search has ended: it has brought nothing new for long, or there is nothing left to find.

How long a search may stagnate is `patience`. It need not wait that long where the residual of its
equation is noise as far as anybody can see without knowing an equation: where rows with almost the
same variables have residuals that do not know of each other. The test costs one search for
neighbors, on a sample, whatever the number of rows is.

References
----------
Stefansson, Koncar, Jones, A note on the gamma test, Neural Computing & Applications 5 (1997),
doi:10.1007/BF01413858: neighbors estimate the noise that no smooth model can explain.
"""

from __future__ import annotations

from functools import cached_property
from typing import Protocol

import numpy as np
from scipy.spatial import KDTree

from ..sparse.parsimony import PERFECT
from ..terms import Product
from .dictionary import Problem

__all__ = ["Plateau", "likeness"]

PATIENCE_IF_DONE = 2  # generations: what leaves nothing, or noise, may be said in a shorter way
ROWS = 10_000  # with ten neighbors each, one percent of the residual's power shows at two sigma
SHARP = 0.005  # largest standard error of a test that may end a search; few rows cannot judge
N_NEIGHBORS = 10
CLOSE = 0.9  # likeness of the equation's own values without which neighbors are too far to judge
CHANCE = 2.0  # standard errors


class _Found(Protocol):
    """What is asked of a generation."""

    @property
    def terms(self) -> tuple[Product, ...]: ...
    @property
    def error(self) -> float: ...


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

    def reached(self, generation: _Found) -> bool:
        """Take note of a generation and tell whether it is the last.

        Notes
        -----
        What counts is a term that no best equation had before: an equation that comes and goes
        from sample to sample is no news. A perfect equation of one variable ends the search at
        once, as nothing is shorter.
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

    def _leaves_noise(self, generation: _Found, shapes: frozenset[Product]) -> bool:
        if self.problem.project is not None:
            return False  # projected rows have no variables of their own
        if shapes not in self._judged:
            sample, neighbors = self._sample
            theta, y = sample.regression(generation.terms)
            basis = np.linalg.qr(theta)[0]
            fitted = basis @ (basis.T @ y)
            close, _ = likeness(fitted - fitted.mean(), neighbors)
            left, error = likeness(y - fitted, neighbors)
            self._judged[shapes] = close >= CLOSE and error <= SHARP and left <= CHANCE * error
        return self._judged[shapes]

    @cached_property
    def _sample(self) -> tuple[Problem, np.ndarray]:
        sample = self.problem.sample(ROWS, np.random.default_rng(0))
        size = sample.x.std(axis=0)
        points = sample.x / np.where(size > 0.0, size, 1.0)
        n_neighbors = min(N_NEIGHBORS, len(points) - 1)
        _, neighbors = KDTree(points).query(points, n_neighbors + 1)
        return sample, neighbors[:, 1:]


def likeness(values: np.ndarray, neighbors: np.ndarray) -> tuple[float, float]:
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
        Share of the signal's power that is a function of where the row lies: one if neighbors are
        equal, about zero for noise (dimensionless).
    error : float
        Standard error of the share if the signal is noise, of the same size everywhere or not.
    """
    power = float(values @ values)
    if power == 0.0:
        return 0.0, 0.0
    near = values[neighbors]
    share = float(values @ near.mean(axis=1)) / power
    # A pair that are neighbors of each other counts twice, hence the two.
    error = np.sqrt(2.0 * float(np.square(values) @ np.square(near).sum(axis=1)))
    return share, error / (neighbors.shape[1] * power)
