"""Backward elimination: an information criterion chooses among the supports on the way down.

Symbols as in `gram`.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .gram import Gram, inverse, least_squares, rss

HEALTHY = 0.1  # of 1 / n, the least diagonal element of the inverse for columns of unit RMS


def front(
    gram: Gram,
    proposals: Sequence[Sequence[int] | np.ndarray],
    penalty: np.ndarray,
    n_effective: float,
    max_terms: int | None = None,
) -> list[np.ndarray]:
    """Eliminate terms backward from several supports and keep the best support of each size.

    Parameters
    ----------
    gram : Gram
        Inner products.
    proposals : sequence of sequence of int
        Supports to begin with.
    penalty : ndarray of shape (p,)
        Price of each column: log n for its coefficient and more for a large tree.
    n_effective : float
        Number of independent rows, below n where residuals are autocorrelated.
    max_terms : int, optional
        Size of the largest support to return.

    Returns
    -------
    list of ndarray of int
        The one with the least information criterion first, then the best of each smaller size.
        Elimination goes on to the empty support, as the criterion may have local minima.
    """
    n, nothing = n_effective, np.arange(0)
    best: dict[int, tuple[float, np.ndarray]] = {0: (n * np.log(_share(gram, gram.yy)), nothing)}
    for proposal in proposals:
        for support, error in eliminate(gram, proposal, penalty, n):
            value = n * np.log(_share(gram, error)) + penalty[support].sum()
            size = len(support)
            if size <= (max_terms or size) and value < best.get(size, (np.inf,))[0]:
                best[size] = (float(value), support)
    found = {size: support for size, (_, support) in best.items()}
    # Downdating loses digits where terms are nearly collinear, so the winners are solved afresh.
    value = {size: information(gram, s, penalty, n) for size, s in found.items()}
    first = min(value, key=lambda size: (value[size], size))
    return [found[size] for size in sorted(found, reverse=True) if size <= first]


def _share(gram: Gram, error: float) -> float:
    return max(error, np.finfo(float).tiny) / gram.n


def default_penalty(gram: Gram, n_effective: float) -> np.ndarray:
    """Price of a term, in the units of `information`, when nothing is known of its complexity.

    This is the extended BIC: log n for its coefficient, 2 log p for having been chosen among p.
    """
    p = len(gram.xy)
    return np.full(p, np.log(max(n_effective, 2.0)) + 2.0 * np.log(max(p, 2)))


def information(gram: Gram, support: np.ndarray, penalty: np.ndarray, n_effective: float) -> float:
    """Information criterion of a support, lower is better: n log(RSS / n) + sum of penalties."""
    error = rss(gram, least_squares(gram, support)) / gram.n
    return float(n_effective * np.log(error) + penalty[support].sum())


def eliminate(
    gram: Gram, support: Sequence[int] | np.ndarray, penalty: np.ndarray, n_effective: float
) -> list[tuple[np.ndarray, float]]:
    """Eliminate terms backward, the least useful first, until none is left.

    Parameters
    ----------
    gram : Gram
        Inner products.
    support : sequence of int
        Columns to begin with.
    penalty : ndarray of shape (p,)
        Price of each column, in units of `information`.
    n_effective : float
        Number of independent rows.

    Returns
    -------
    list of (ndarray of int, float)
        Each support on the way down and its residual sum of squares.

    Notes
    -----
    Each step costs k^2 on a support of k terms, because the inverse is downdated.
    """
    columns = np.asarray(support, dtype=int)
    part = gram.select(columns)
    part = part.scaled(part.scale)
    inverted = inverse(part)
    coef, price = inverted @ part.xy, penalty[columns]
    floor = gram.rounding
    error = max(float(gram.yy - coef @ part.xy), floor)
    path = [(columns, error)]
    alive = np.ones(len(columns), dtype=bool)
    for _ in columns:
        # Dropped columns keep their place, with zeros in the inverse.
        if inverted.diagonal()[alive].min() < HEALTHY / gram.n:  # downdating has lost its digits
            inverted, coef = _inverted_again(part, alive)
        rise = _rise(coef, inverted, gram.n)
        with np.errstate(over="ignore"):  # rise / error may overflow after an exact fit
            worth = n_effective * np.log1p(rise / error) - price
        worth[~alive] = np.inf
        worst = int(worth.argmin())
        error = max(error + float(rise[worst]), floor)
        alive[worst] = False
        column, pivot = inverted[:, worst].copy(), inverted[worst, worst]
        if abs(pivot) >= HEALTHY / gram.n:
            coef -= column * (coef[worst] / pivot)
            inverted -= column[:, None] * (column / pivot)
        inverted[worst], inverted[:, worst], coef[worst] = 0.0, 0.0, 0.0
        path.append((columns[alive], error))
    return path


def _inverted_again(part: Gram, alive: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the inverse for the columns alive, zeros for the others, and the coefficients."""
    inverted, coef = np.zeros_like(part.xx), np.zeros_like(part.xy)
    kept = np.flatnonzero(alive)
    inverted[np.ix_(kept, kept)] = inverse(part.select(kept))
    coef[kept] = inverted[np.ix_(kept, kept)] @ part.xy[kept]
    return inverted, coef


def gains(gram: Gram, support: Sequence[int] | np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the residual sum of squares of an equation with and without each column.

    Parameters
    ----------
    gram : Gram
        Inner products; columns should have similar sizes.
    support : sequence of int
        Terms of the equation.

    Returns
    -------
    with_column, without_column : ndarray of shape (p,)
        Residual sums of squares, in units of the target squared.
    """
    support = np.asarray(support, dtype=int)
    inverted = inverse(gram.select(support))
    coef = inverted @ gram.xy[support]
    floor = gram.rounding
    error = max(float(gram.yy - coef @ gram.xy[support]), floor)
    cross = gram.xx[support]
    slope = gram.xy - coef @ cross
    power = np.diag(gram.xx) - np.einsum("ij,ij->j", cross, inverted @ cross)
    independent = power > 1e-9 * np.diag(gram.xx)
    gain = np.divide(slope**2, power, out=np.zeros(len(power)), where=independent)
    with_column, without_column = np.maximum(error - gain, floor), np.full(len(gram.xy), error)
    with_column[support] = error
    without_column[support] = error + _rise(coef, inverted, gram.n)
    return with_column, without_column


def _rise(coef: np.ndarray, inverted: np.ndarray, n: int) -> np.ndarray:
    """Return the rise of the residual sum of squares without each column; 0 for a zero column."""
    diagonal = inverted.diagonal()
    usable = diagonal > 1e-12 / n
    return np.divide(coef * coef, diagonal, out=np.zeros_like(coef), where=usable)
