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

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import reduce
from itertools import pairwise

import numpy as np
from scipy.linalg.lapack import dpotrf, dpotri

# Rows a chunk: a chunk of 20 columns takes 1.3 MB, about a processor's cache.
ROWS_PER_CHUNK = 1 << 13
# Share of y @ y below which a Gram matrix in double precision sees only rounding.
MIN_SQUARE_SHARE = 1e-13
RIDGE = 1e-12  # keeps nearly equal columns of unit size solvable without moving the others


@dataclass(frozen=True, eq=False)
class Gram:
    """Inner products of n rows, which are all that least squares needs.

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
        size = np.sqrt(np.maximum(np.diag(self.xx), 0.0) / self.n)  # rounding may be below zero
        return np.where(size > 0.0, size, 1.0)

    @property
    def rounding(self) -> float:
        """Residual sum of squares below which there is only rounding."""
        return max(MIN_SQUARE_SHARE * self.yy, np.finfo(float).tiny)

    def scaled(self, scale: np.ndarray) -> Gram:
        """Divide the columns by `scale`; the target stays."""
        return Gram(self.xx / np.outer(scale, scale), self.xy / scale, self.yy, self.n)

    def select(self, columns: Sequence[int] | np.ndarray) -> Gram:
        """Keep some of the columns."""
        index = np.asarray(columns, dtype=int)
        return Gram(self.xx[np.ix_(index, index)], self.xy[index], self.yy, self.n)

    def without(self, n_fixed: int) -> Gram:
        """Project the first `n_fixed` columns out of the others and of the target.

        Regression on the result gives the same coefficients as regression on all columns
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
    return target_grams(columns, y[:, None], n_blocks)[0]


def target_grams(
    columns: Callable[[slice], np.ndarray], targets: np.ndarray, n_blocks: int = 1
) -> list[list[Gram]]:
    """Take the `block_grams` of several targets in one pass over the rows.

    Parameters
    ----------
    columns, n_blocks
        As in `block_grams`.
    targets : ndarray of shape (n, n_targets)
        Targets.

    Returns
    -------
    list of list of Gram
        The blocks of each target.
    """
    edges = np.linspace(0, len(targets), n_blocks + 1).astype(int)
    found: list[list[Gram]] = [[] for _ in targets.T]
    for start, stop in pairwise(edges):
        pieces = [_products(columns(rows), targets[rows]) for rows in chunks(start, stop)]
        xx, xy, yy = (np.sum(products, axis=0) for products in zip(*pieces, strict=True))
        for k, blocks in enumerate(found):
            blocks.append(Gram(xx, xy[:, k], float(yy[k]), stop - start))
    return found


def _products(theta: np.ndarray, targets: np.ndarray) -> tuple[np.ndarray, ...]:
    with np.errstate(all="ignore"):  # a column may have poles on rows that no search has seen
        return theta.T @ theta, theta.T @ targets, np.einsum("ij,ij->j", targets, targets)


def chunks(start: int, stop: int) -> Iterator[slice]:
    """Cut rows into pieces that fit into the cache of a processor."""
    return (slice(a, min(a + ROWS_PER_CHUNK, stop)) for a in range(start, stop, ROWS_PER_CHUNK))


def residual(columns: Callable[[slice], np.ndarray], y: np.ndarray, coef: np.ndarray) -> np.ndarray:
    """Return y - theta @ coef without holding all rows of theta.

    Parameters
    ----------
    columns, y
        As in `block_grams`.
    coef : ndarray of shape (p,)
        Coefficients.

    Returns
    -------
    ndarray of shape (n,)
    """
    result = np.empty(len(y))
    for rows in chunks(0, len(y)):
        result[rows] = y[rows] - columns(rows) @ coef
    return result


def refined(columns: Callable[[slice], np.ndarray], y: np.ndarray, whole: Gram) -> np.ndarray:
    """Solve least squares on all columns, as precisely as on theta itself.

    Parameters
    ----------
    columns, y
        As in `block_grams`.
    whole : Gram
        Their inner products.

    Returns
    -------
    ndarray of shape (p,)

    Notes
    -----
    Gram matrices square the condition number. A second solution, for the residual, restores the
    digits that were lost to rounding (iterative refinement).
    """
    every = np.arange(len(whole.xy))
    coef = least_squares(whole, every)
    gradient = np.zeros_like(coef)
    for rows in chunks(0, len(y)):
        theta = columns(rows)
        gradient += theta.T @ (y[rows] - theta @ coef)
    return coef + least_squares(Gram(whole.xx, gradient, whole.yy, whole.n), every)


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
    """Residual sum of squares, at least the size of its rounding error."""
    value = gram.yy - 2.0 * coef @ gram.xy + coef @ gram.xx @ coef
    return max(float(value), gram.rounding)


def inverse(part: Gram) -> np.ndarray:
    """Invert xx, nearly equal columns included; columns should be of unit RMS."""
    if not len(part.xy):
        return np.empty((0, 0))
    xx = part.xx + RIDGE * part.n * np.eye(len(part.xy))
    factor, failed = dpotrf(xx, lower=1)
    if not failed:
        half, failed = dpotri(factor, lower=1)
    if failed:  # rounding has made it indefinite: ten times slower, but works
        return np.linalg.pinv(xx, rcond=1e-15, hermitian=True)
    return np.tril(half) + np.tril(half, -1).T
