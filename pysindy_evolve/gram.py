"""Least squares on Gram matrices: the rows are touched once, everything else is small.

======  ===================  ==========================================================
symbol  shape                meaning
======  ===================  ==========================================================
theta   (n, p)               dictionary, one column for each term
y       (n,)                 target
xx      (p, p)               theta.T @ theta
xy      (p,)                 theta.T @ y
yy      float                y @ y
coef    (p,)                 coefficients, in units of y per unit of the column
======  ===================  ==========================================================
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import reduce
from itertools import pairwise

import numpy as np

__all__ = ["LEAST", "Gram", "block_grams", "gram", "inverse", "least_squares", "rss", "total"]

CHUNK = 1 << 14  # rows a chunk: a chunk of 100 columns takes 13 MB
LEAST = 1e-13  # share of y @ y below which a Gram matrix in double precision sees only rounding
RIDGE = 1e-12  # keeps nearly equal columns of unit size solvable without moving the others


@dataclass(frozen=True, eq=False)
class Gram:
    """What least squares needs to know of n rows.

    Parameters
    ----------
    xx : ndarray of shape (p, p)
        Inner products of the columns.
    xy : ndarray of shape (p,)
        Inner products of the columns with the target.
    yy : float
        Inner product of the target with itself.
    n : int
        Number of rows.
    """

    xx: np.ndarray
    xy: np.ndarray
    yy: float
    n: int

    def __add__(self, other: Gram) -> Gram:
        """Join two sets of rows."""
        return Gram(self.xx + other.xx, self.xy + other.xy, self.yy + other.yy, self.n + other.n)

    def __sub__(self, other: Gram) -> Gram:
        """Leave out rows that are part of this set."""
        return Gram(self.xx - other.xx, self.xy - other.xy, self.yy - other.yy, self.n - other.n)

    @property
    def scale(self) -> np.ndarray:
        """RMS of each column; one where a column is zero."""
        size = np.sqrt(np.diag(self.xx) / self.n)
        return np.where(size > 0.0, size, 1.0)

    def scaled(self, scale: np.ndarray) -> Gram:
        """Divide the columns by `scale`; the target stays."""
        return Gram(self.xx / np.outer(scale, scale), self.xy / scale, self.yy, self.n)

    def select(self, columns: Sequence[int] | np.ndarray) -> Gram:
        """Keep some of the columns."""
        index = np.asarray(columns, dtype=int)
        return Gram(self.xx[np.ix_(index, index)], self.xy[index], self.yy, self.n)

    def without(self, n_fixed: int) -> Gram:
        """Project the first `n_fixed` columns out of the others and of the target.

        Regression on what is left gives the coefficients of a regression on all of them
        (Frisch and Waugh), so fixed columns cost nothing in the search.
        """
        if n_fixed == 0:
            return self
        scale = self.scale[:n_fixed]
        fixed = self.xx[:n_fixed, :n_fixed] / np.outer(scale, scale)
        inverted = np.linalg.pinv(fixed, rcond=1e-12, hermitian=True)
        cross, target = self.xx[:n_fixed, n_fixed:] / scale[:, None], self.xy[:n_fixed] / scale
        return Gram(
            self.xx[n_fixed:, n_fixed:] - cross.T @ inverted @ cross,
            self.xy[n_fixed:] - cross.T @ inverted @ target,
            max(float(self.yy - target @ inverted @ target), 0.0),
            self.n,
        )


def gram(theta: np.ndarray, y: np.ndarray) -> Gram:
    """Take the inner products of all columns.

    Parameters
    ----------
    theta : ndarray of shape (n, p)
        Dictionary.
    y : ndarray of shape (n,)
        Target.

    Returns
    -------
    Gram

    Examples
    --------
    >>> import numpy as np
    >>> x = np.arange(4.0)
    >>> least_squares(gram(np.column_stack([x, x**2]), 3 * x), [0, 1]).round(6)
    array([3., 0.])
    """
    return Gram(theta.T @ theta, theta.T @ y, float(y @ y), len(y))


def block_grams(
    columns: Callable[[slice], np.ndarray], y: np.ndarray, n_blocks: int = 1
) -> list[Gram]:
    """Take Gram matrices of consecutive blocks of rows, without holding all rows of theta.

    Parameters
    ----------
    columns : callable
        Maps a slice of rows to the rows of theta, shape (rows, p).
    y : ndarray of shape (n,)
        Target.
    n_blocks : int
        Number of blocks. Their sum is the Gram matrix of all rows; leaving one out is a
        subtraction, so held-out checks cost no second pass over the rows.

    Returns
    -------
    list of Gram
    """
    edges = np.linspace(0, len(y), n_blocks + 1).astype(int)
    blocks = []
    for start, stop in pairwise(edges):
        pieces = (slice(a, min(a + CHUNK, stop)) for a in range(start, stop, CHUNK))
        blocks.append(total(gram(columns(rows), y[rows]) for rows in pieces))
    return blocks


def total(grams: Iterable[Gram]) -> Gram:
    """Join the rows of several Gram matrices."""
    return reduce(Gram.__add__, grams)


def least_squares(gram: Gram, support: Sequence[int] | np.ndarray) -> np.ndarray:
    """Solve least squares on a support.

    Parameters
    ----------
    gram : Gram
        Inner products.
    support : sequence of int
        Columns that may have a coefficient.

    Returns
    -------
    ndarray of shape (p,)
        Coefficients, zero outside the support.
    """
    coef = np.zeros(len(gram.xy))
    support = np.asarray(support, dtype=int)
    if len(support):
        part = gram.select(support)
        scale = part.scale
        coef[support] = inverse(part.scaled(scale)) @ (part.xy / scale) / scale
    return coef


def rss(gram: Gram, coef: np.ndarray) -> float:
    """Residual sum of squares, not below what rounding allows to see."""
    value = gram.yy - 2.0 * coef @ gram.xy + coef @ gram.xx @ coef
    return max(float(value), LEAST * gram.yy, np.finfo(float).tiny)


def inverse(part: Gram) -> np.ndarray:
    """Invert xx, nearly equal columns included; columns should be of unit RMS."""
    ridge = RIDGE * part.n * np.eye(len(part.xy))
    return np.linalg.pinv(part.xx + ridge, rcond=1e-15, hermitian=True)
