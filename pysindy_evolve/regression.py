"""Sparse regression on Gram matrices: the rows are touched once, everything else is small.

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

The elastic net, equation (11) of the paper, proposes supports; backward elimination by an
information criterion chooses among them; least squares decides the coefficients. An elastic net
alone never gives the exact support: it keeps shadows of the true terms.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import reduce
from itertools import pairwise

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft
from sklearn.exceptions import ConvergenceWarning
from sklearn.linear_model import lars_path_gram

__all__ = [
    "Gram", "block_grams", "default_penalty", "effective_size", "elastic_net", "frugal", "gains",
    "gram",
    "information", "least_squares", "path", "prune", "stable", "supports",
]  # fmt: skip

CHUNK = 1 << 14  # rows a chunk: a chunk of 100 columns takes 13 MB
LEAST = 1e-13  # share of y @ y below which a Gram matrix in double precision sees only rounding
HEALTHY = 0.1  # of 1 / n, below which no diagonal of an inverse lies where columns have unit RMS
RIDGE = 1e-12  # keeps nearly equal columns of unit size solvable without moving the others
MATERIAL = 1e-5  # share of the target's power: no derivative is good to better than 0.3 %
REMAINDER = 1e-2  # share of the error that a smaller term may leave, if it is to count
FORWARD = 6  # steps of forward selection beside the elastic net
LAMBDA2 = (1e-3, 1e-1)  # relative to columns of unit RMS; orders of magnitude are enough


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
        inverse = np.linalg.pinv(fixed, rcond=1e-12, hermitian=True)
        cross, target = self.xx[:n_fixed, n_fixed:] / scale[:, None], self.xy[:n_fixed] / scale
        return Gram(
            self.xx[n_fixed:, n_fixed:] - cross.T @ inverse @ cross,
            self.xy[n_fixed:] - cross.T @ inverse @ target,
            max(float(self.yy - target @ inverse @ target), 0.0),
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
        coef[support] = _inverse(part.scaled(scale)) @ (part.xy / scale) / scale
    return coef


def rss(gram: Gram, coef: np.ndarray) -> float:
    """Residual sum of squares, not below what rounding allows to see."""
    value = gram.yy - 2.0 * coef @ gram.xy + coef @ gram.xx @ coef
    return max(float(value), LEAST * gram.yy, np.finfo(float).tiny)


def _inverse(part: Gram) -> np.ndarray:
    ridge = RIDGE * part.n * np.eye(len(part.xy))
    return np.linalg.pinv(part.xx + ridge, rcond=1e-15, hermitian=True)


def elastic_net(gram: Gram, lambda1: float, lambda2: float, max_sweeps: int = 10_000) -> np.ndarray:
    """Minimize ||theta coef - y||^2 + lambda1 ||coef||_1 + lambda2 ||coef||^2, equation (11).

    Parameters
    ----------
    gram : Gram
        Inner products.
    lambda1, lambda2 : float
        Weights of the penalties, at least zero.
    max_sweeps : int
        Most sweeps over the coordinates.

    Returns
    -------
    ndarray of shape (p,)

    Notes
    -----
    Cyclic coordinate descent on the Gram matrix, until no coordinate moves by more than 1e-12 of
    the target's size; a sweep costs p^2.
    """
    coef, gradient = np.zeros(len(gram.xy)), gram.xy.copy()
    curvature = np.diag(gram.xx) + lambda2
    for _ in range(max_sweeps):
        largest = 0.0
        for j in np.flatnonzero(curvature > 0.0):
            pull = gradient[j] + gram.xx[j, j] * coef[j]
            new = np.sign(pull) * max(abs(pull) - lambda1 / 2.0, 0.0) / curvature[j]
            if step := new - coef[j]:
                gradient -= gram.xx[:, j] * step
                coef[j] = new
                largest = max(largest, abs(step) * np.sqrt(curvature[j]))
        if largest <= 1e-12 * np.sqrt(gram.yy):
            return coef
    warnings.warn(
        f"elastic_net(max_sweeps=...) should be larger: after {max_sweeps} sweeps a coefficient "
        f"still moved by {largest:.2g}. Raise it, or raise lambda2.",
        ConvergenceWarning,
        stacklevel=2,
    )
    return coef
    return coef


def path(gram: Gram, lambda2: float, max_steps: int = 40) -> tuple[np.ndarray, np.ndarray]:
    """Follow the elastic net from lambda1 = infinity downward, knot by knot.

    Parameters
    ----------
    gram : Gram
        Inner products; columns should have similar sizes.
    lambda2 : float
        Weight of the squared penalty in equation (11).
    max_steps : int
        Number of knots, which bounds the number of terms.

    Returns
    -------
    lambda1 : ndarray of shape (n_knots,)
        Falling.
    coef : ndarray of shape (n_knots, p)
        Solutions of equation (11); between knots they are linear in lambda1.

    Notes
    -----
    An elastic net is a lasso on xx + lambda2 I, whose path least-angle regression follows exactly.
    """
    xx = gram.xx + lambda2 * np.eye(len(gram.xy))
    with warnings.catch_warnings():
        # A path that stops early at a degenerate corner still proposes good supports.
        warnings.simplefilter("ignore", ConvergenceWarning)
        warnings.simplefilter("ignore", RuntimeWarning)
        alphas, _, coef = lars_path_gram(
            gram.xy, xx, n_samples=gram.n, max_iter=max_steps, method="lasso", copy_Gram=False
        )
    return 2.0 * gram.n * np.asarray(alphas), np.asarray(coef).T


def supports(gram: Gram, max_terms: int, lambda2: Sequence[float] = LAMBDA2) -> list[np.ndarray]:
    """Propose supports from sweeps of lambda1 and lambda2 over orders of magnitude.

    Parameters
    ----------
    gram : Gram
        Inner products, in any units: columns are brought to unit RMS here.
    max_terms : int
        Size of the largest support.
    lambda2 : sequence of float
        Weights of the squared penalty, relative to n columns of unit RMS.

    Returns
    -------
    list of ndarray of int
        The largest support of each path, one of half its size, and what forward selection finds:
        where all terms are nearly collinear, as on a closed orbit, it is the short way.
    """
    scaled = gram.scaled(gram.scale)
    found = []
    for weight in lambda2:
        _, coef = path(scaled, weight * gram.n, max_steps=2 * max_terms)
        sizes = np.count_nonzero(coef, axis=1)
        for size in (max_terms, max_terms // 2):
            knots = np.flatnonzero(sizes <= size)
            if len(knots):
                found.append(np.flatnonzero(coef[knots[np.argmax(sizes[knots])]]))
    return [*found, _forward(scaled, min(max_terms, FORWARD))]


def _forward(gram: Gram, max_terms: int) -> np.ndarray:
    """Add the column that helps most, again and again."""
    support: list[int] = []
    for _ in range(min(max_terms, len(gram.xy))):
        with_column, _ = gains(gram, support)
        support.append(int(np.argmin(with_column)))
        if with_column[support[-1]] <= 2.0 * LEAST * gram.yy:
            break
    return np.array(sorted(set(support)), dtype=int)


def default_penalty(gram: Gram, n_effective: float | None = None) -> np.ndarray:
    """Price of a term, in the units of `information`, when nothing is known of its complexity.

    This is the extended BIC: log n for its coefficient, 2 log p for having been chosen among p.
    """
    p = len(gram.xy)
    n = gram.n if n_effective is None else n_effective
    return np.full(p, np.log(max(n, 2.0)) + 2.0 * np.log(max(p, 2)))


def information(
    gram: Gram,
    support: Sequence[int] | np.ndarray,
    penalty: np.ndarray | None = None,
    n_effective: float | None = None,
) -> float:
    """Information criterion of a support, lower is better: n log(RSS / n) + sum of penalties."""
    penalty = default_penalty(gram, n_effective) if penalty is None else penalty
    n = gram.n if n_effective is None else n_effective
    error = rss(gram, least_squares(gram, support)) / gram.n
    return float(n * np.log(error) + penalty[np.asarray(support, dtype=int)].sum())


def eliminate(
    gram: Gram,
    support: Sequence[int] | np.ndarray,
    penalty: np.ndarray,
    n_effective: float,
) -> list[tuple[np.ndarray, float]]:
    """Eliminate terms backward, the one that is worth least first, until none is left.

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
    left = np.asarray(support, dtype=int)
    part = gram.select(left)
    part = part.scaled(part.scale)
    inverse = _inverse(part)
    coef, price = inverse @ part.xy, penalty[left]
    floor = max(LEAST * gram.yy, np.finfo(float).tiny)
    error = max(float(gram.yy - coef @ part.xy), floor)
    way = [(left, error)]
    alive = np.arange(len(left))
    while len(left):
        if np.min(np.diag(inverse)) < HEALTHY / gram.n:  # downdating has lost its digits
            inverse = _inverse(part.select(alive))
            coef = inverse @ part.xy[alive]
        rise = _rise(coef, inverse, gram.n)
        worst = int(np.argmin(n_effective * np.log1p(rise / error) - price))
        error = max(error + float(rise[worst]), floor)
        keep = np.arange(len(left)) != worst
        column, pivot = inverse[keep, worst], inverse[worst, worst]
        if abs(pivot) >= HEALTHY / gram.n:
            coef = coef[keep] - column * coef[worst] / pivot
            inverse = inverse[np.ix_(keep, keep)] - np.outer(column, column) / pivot
        else:
            coef, inverse = coef[keep], inverse[np.ix_(keep, keep)]
        left, price, alive = left[keep], price[keep], alive[keep]
        way.append((left, error))
    return way


def _rise(coef: np.ndarray, inverse: np.ndarray, n: int) -> np.ndarray:
    """Return what the sum of squares rises by without each column; nothing for a zero column."""
    diagonal = np.diag(inverse)
    usable = diagonal > 1e-12 / n
    return np.where(usable, coef**2 / np.where(usable, diagonal, 1.0), 0.0)


def prune(
    gram: Gram,
    support: Sequence[int] | np.ndarray,
    penalty: np.ndarray | None = None,
    n_effective: float | None = None,
    max_terms: int | None = None,
) -> np.ndarray:
    """Eliminate terms backward and return the support with the least information criterion.

    Parameters
    ----------
    gram : Gram
        Inner products.
    support : sequence of int
        Columns to begin with.
    penalty : ndarray of shape (p,), optional
        Price of each column: log n for its coefficient and more for a large tree. By default
        `default_penalty`.
    n_effective : float, optional
        Number of independent rows, below n where residuals are autocorrelated.
    max_terms : int, optional
        Size of the largest support to return.

    Returns
    -------
    ndarray of int
        What is left of the support. The whole way down is walked, as the criterion may have local
        minima.
    """
    return front(gram, [support], penalty, n_effective, max_terms)[0]


def front(
    gram: Gram,
    proposals: Sequence[Sequence[int] | np.ndarray],
    penalty: np.ndarray | None = None,
    n_effective: float | None = None,
    max_terms: int | None = None,
) -> list[np.ndarray]:
    """Eliminate terms backward from several supports and keep the best support of each size.

    Parameters
    ----------
    gram : Gram
        Inner products.
    proposals : sequence of sequence of int
        Supports to begin with.
    penalty, n_effective, max_terms
        As in `prune`.

    Returns
    -------
    list of ndarray of int
        The one with the least information criterion first, then the best of each smaller size.
    """
    n = float(gram.n) if n_effective is None else n_effective
    penalty = default_penalty(gram, n) if penalty is None else penalty
    best: dict[int, tuple[float, tuple[int, ...]]] = {0: (n * np.log(_share(gram, gram.yy)), ())}
    for proposal in proposals:
        for support, error in eliminate(gram, proposal, penalty, n):
            value = n * np.log(_share(gram, error)) + penalty[support].sum()
            size = len(support)
            if size <= (max_terms or size) and value < best.get(size, (np.inf,))[0]:
                best[size] = (float(value), tuple(support))
    found = {size: np.array(support, dtype=int) for size, (_, support) in best.items()}
    # Downdating loses digits where terms are nearly collinear, so the winners are solved afresh.
    value = {size: information(gram, s, penalty, n) for size, s in found.items()}
    first = min(value, key=lambda size: (value[size], size))
    return [found[size] for size in sorted(found, reverse=True) if size <= first]


def _share(gram: Gram, error: float) -> float:
    return max(error, np.finfo(float).tiny) / gram.n


def frugal(gram: Gram, front: Sequence[np.ndarray]) -> list[np.ndarray]:
    """Leave out equations of a front where a smaller one fits as well as a derivative is known.

    Parameters
    ----------
    gram : Gram
        Inner products.
    front : list of ndarray of int
        As `front` returns it, largest first.

    Returns
    -------
    list of ndarray of int
        What is left of the front; see `material` for the reason and the measure.
    """
    errors = [rss(gram, least_squares(gram, support)) for support in front]
    limit = max(errors[0], MATERIAL * gram.yy)
    chosen = max(i for i, error in enumerate(errors) if error <= limit)
    for i in range(chosen - 1, -1, -1):
        if errors[i] <= errors[chosen] * REMAINDER ** (len(front[i]) - len(front[chosen])):
            chosen = i
    return list(front[chosen:])


def material(gram: Gram, support: Sequence[int] | np.ndarray) -> np.ndarray:
    """Drop terms too small to be told from the error of a derivative.

    Parameters
    ----------
    gram : Gram
        Inner products.
    support : sequence of int
        Columns to begin with.

    Returns
    -------
    ndarray of int
        Terms without which more than `MATERIAL` of the target's power would be left, or a
        hundred times as much as with them, as on exact data. The smallest goes first.

    Notes
    -----
    A finite difference errs by a smooth function of the state. Terms that fit it are significant
    by any statistical test, and would be found where nothing is missing.
    """
    support = np.asarray(support, dtype=int)
    scaled = gram.scaled(gram.scale)
    while len(support):
        _, without = gains(scaled, support)
        error = rss(scaled, least_squares(scaled, support))
        rise = without[support] - error
        worst = int(np.argmin(rise))
        if error + rise[worst] >= MATERIAL * gram.yy or rise[worst] >= error / REMAINDER:
            break
        support = np.delete(support, worst)
    return support


def gains(gram: Gram, support: Sequence[int] | np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Weigh every column against the best equation.

    Parameters
    ----------
    gram : Gram
        Inner products; columns should have similar sizes.
    support : sequence of int
        Terms of the equation.

    Returns
    -------
    with_column, without_column : ndarray of shape (p,)
        Residual sums of squares of the equation with and without each column.
    """
    support = np.asarray(support, dtype=int)
    inverse = _inverse(gram.select(support))
    coef = inverse @ gram.xy[support]
    floor = max(LEAST * gram.yy, np.finfo(float).tiny)
    error = max(float(gram.yy - coef @ gram.xy[support]), floor)
    cross = gram.xx[support]
    slope = gram.xy - coef @ cross
    power = np.diag(gram.xx) - np.einsum("ij,ij->j", cross, inverse @ cross)
    gain = np.where(power > 1e-9 * np.diag(gram.xx), slope**2 / np.maximum(power, 1e-300), 0.0)
    with_column, without_column = np.maximum(error - gain, floor), np.full(len(gram.xy), error)
    with_column[support] = error
    without_column[support] = error + _rise(coef, inverse, gram.n)
    return with_column, without_column


def stable(
    whole: Gram,
    folds: Sequence[Gram],
    support: Sequence[int] | np.ndarray,
    min_ratio: float = 3.0,
) -> np.ndarray:
    """Drop terms whose coefficient is not the same, within its scatter, all along the record.

    Parameters
    ----------
    whole : Gram
        All rows.
    folds : sequence of Gram
        All rows but one block each, see `block_grams`.
    support : sequence of int
        Columns to begin with.
    min_ratio : float
        Least ratio of a coefficient to its standard error (dimensionless).

    Returns
    -------
    ndarray of int
        What is left of the support.

    Notes
    -----
    The standard error is the jackknife's over blocks, which holds for autocorrelated residuals as
    long as blocks are longer than their memory. The weakest term goes first.
    """
    support = np.asarray(support, dtype=int)
    while len(support):
        ratio = _jackknife_ratio(whole, folds, support)
        worst = int(np.argmin(ratio))
        if ratio[worst] >= min_ratio:
            break
        support = np.delete(support, worst)
    return support


def _jackknife_ratio(whole: Gram, folds: Sequence[Gram], support: np.ndarray) -> np.ndarray:
    coef = np.array([least_squares(fold, support)[support] for fold in folds])
    count = len(folds)
    error = np.sqrt((count - 1) / count * ((coef - coef.mean(axis=0)) ** 2).sum(axis=0))
    size = np.abs(least_squares(whole, support)[support])
    return size / np.maximum(error, np.finfo(float).tiny)


def effective_size(residual: np.ndarray) -> float:
    """Count the independent samples in an autocorrelated series.

    Parameters
    ----------
    residual : ndarray of shape (n,)
        In order of time.

    Returns
    -------
    float
        n / (1 + 2 sum of autocorrelations up to their first zero), at least 8.
    """
    n = len(residual)
    centered = residual - residual.mean()
    power = float(centered @ centered)
    if n < 16 or power <= 0.0:
        return float(n)
    length = next_fast_len(n + n // 2, real=True)  # padded for lags up to n / 2
    spectrum = np.abs(rfft(centered, length)) ** 2
    correlation = irfft(spectrum, length)[1 : n // 2] / power
    # 2/sqrt(n) is what white noise shows by chance.
    quiet = np.flatnonzero(correlation < 2.0 / np.sqrt(n))
    until = quiet[0] if len(quiet) else len(correlation)
    return max(n / (1.0 + 2.0 * float(correlation[:until].sum())), 8.0)
