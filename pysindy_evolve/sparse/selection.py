"""Chooses one equation among all proposals, allowing for the autocorrelation of its residual.

Symbols as in `gram`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from .elimination import front
from .gram import Gram
from .independence import effective_size
from .parsimony import PERFECT, prefer_smaller

__all__ = ["Selection", "select"]


@dataclass(frozen=True, eq=False)
class Selection:
    """The best equations, with the prices and the number of rows that decided between them.

    Parameters
    ----------
    front : list of ndarray of int
        Supports: the best one first, then smaller ones.
    cost : ndarray of shape (p,)
        Price of each column, in units of `information`.
    n_effective : float
        Number of independent rows in the residual of the best one.
    """

    front: list[np.ndarray]
    cost: np.ndarray
    n_effective: float

    @property
    def best(self) -> np.ndarray:
        """The support with the least information criterion."""
        return self.front[0]


def select(
    gram: Gram,
    proposals: Sequence[np.ndarray],
    price: Callable[[float], np.ndarray],
    residual: Callable[[np.ndarray], np.ndarray],
    power: float,
    max_terms: int | None = None,
    propose: Callable[[np.ndarray, float], list[np.ndarray]] | None = None,
) -> Selection:
    """Prune proposed supports, first with all rows as independent, then with their true number.

    Parameters
    ----------
    gram : Gram
        Inner products.
    proposals : sequence of ndarray of int
        Supports to begin with.
    price : callable
        Maps a number of independent rows to the price of each column.
    residual : callable
        Maps a support to its residual, in order of time.
    power : float
        Sum of squares of the target, that of its fixed part included.
    max_terms : int, optional
        Size of the largest support.
    propose : callable, optional
        Maps prices and a number of independent rows to more supports to begin with.

    Returns
    -------
    Selection
    """
    n_effective = float(gram.n)
    for _ in range(2):
        cost = price(n_effective)
        if propose is not None:
            proposals = [*proposals, *propose(cost, n_effective)]
        supports = prefer_smaller(gram, front(gram, proposals, cost, n_effective, max_terms))
        remainder = residual(supports[0])
        if remainder @ remainder <= PERFECT * power:
            break  # the residual is rounding
        n_before, n_effective = n_effective, effective_size(remainder)
        if n_effective == n_before:
            break  # white residual: a second pass would change nothing
    return Selection(supports, cost, n_effective)
