"""Chooses one equation among all proposals, allowing for the autocorrelation of its residual.

Symbols as in `gram`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft

from .elimination import front
from .gram import Gram
from .parsimony import PERFECT, prefer_smaller

DIRECT = 8  # lags taken one by one; for nearly white noise the sum ends among them
BLOCK = 1 << 17  # samples whose correlations are taken at once; lags go up to half of it


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


def effective_size(residual: np.ndarray) -> float:
    """Count the independent samples in an autocorrelated series.

    Parameters
    ----------
    residual : ndarray of shape (n,)
        In order of time.

    Returns
    -------
    float
        n / (1 + 2 sum of autocorrelations before the first below 2 / sqrt(n)), at least 8; n
        itself for fewer than 16 samples.
    """
    n = len(residual)
    centered = residual - residual.mean()
    power = float(centered @ centered)
    if n < 16 or power <= 0.0:
        return float(n)
    quiet = 2.0 / np.sqrt(n)  # what white noise shows by chance
    total = 0.0
    for lag in range(1, min(DIRECT, n // 2)):
        correlation = float(centered[lag:] @ centered[:-lag]) / power
        if correlation < quiet:
            return max(n / (1.0 + 2.0 * total), 8.0)
        total += correlation
    correlations = _autocorrelation(centered) / power
    below = np.flatnonzero(correlations < quiet)
    until = below[0] if len(below) else len(correlations)
    return max(n / (1.0 + 2.0 * float(correlations[:until].sum())), 8.0)


def _autocorrelation(values: np.ndarray) -> np.ndarray:
    """Sum the products at lags from one to half a block, over blocks of the series."""
    n = min(len(values), BLOCK)
    length = next_fast_len(n + n // 2, real=True)  # padded for lags up to n / 2
    total = np.zeros(n // 2 - 1)
    for start in range(0, len(values), n):
        spectrum = rfft(values[start : start + n], length)
        total += irfft(np.abs(spectrum) ** 2, length)[1 : n // 2]
    return total
