"""Drops terms that are significant, but not needed. Symbols as in `gram`.

A term may be significant and still be false: it fits the smooth error of a derivative, it shows in
one part of the record only, or it takes the place of a simpler one.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .elimination import gains
from .gram import Gram, inverse, least_squares, rss

N_BLOCKS = 12  # parts of the record that a coefficient must agree on
MIN_ROWS = 20  # least rows of such a part
PERFECT = 1e-11  # share of the target's power at which there is nothing left to explain
MATERIAL = 1e-5  # share of the target's power: no derivative is more accurate than 0.3 %
MIN_STANDARD_ERRORS = 6.0  # standard errors that keep a term which only one block shows
DOMINANT = 1e-2  # share of the target's power that no chance correlation explains
REMAINDER = 1e-2  # a term below `MATERIAL` still counts if it cuts the error to this share


def prefer_smaller(gram: Gram, front: Sequence[np.ndarray]) -> list[np.ndarray]:
    """Drop equations of a front where a smaller one fits within the accuracy of a derivative.

    Parameters
    ----------
    gram : Gram
        Inner products.
    front : list of ndarray of int
        As `front` returns it, largest first.

    Returns
    -------
    list of ndarray of int
        The rest of the front; see `drop_immaterial` for the reason and the limit.
    """
    errors = [rss(gram, least_squares(gram, support)) for support in front]
    limit = max(errors[0], MATERIAL * gram.yy)
    chosen = max(i for i, error in enumerate(errors) if error <= limit)
    for i in range(chosen - 1, -1, -1):
        if errors[i] <= errors[chosen] * REMAINDER ** (len(front[i]) - len(front[chosen])):
            chosen = i
    return list(front[chosen:])


def drop_immaterial(
    gram: Gram, support: Sequence[int] | np.ndarray, least: float = 0.0
) -> np.ndarray:
    """Drop terms too small to be distinguished from the error of a derivative.

    Parameters
    ----------
    gram : Gram
        Inner products.
    support : sequence of int
        Columns to begin with.
    least : float
        Sum of squares that every term must explain, in units of the target squared.

    Returns
    -------
    ndarray of int
        Terms whose removal would leave more than `MATERIAL` of the target's power, or, on exact
        data, a hundred times the error. The smallest is dropped first.

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
        counts = error + rise[worst] >= MATERIAL * gram.yy or rise[worst] >= error / REMAINDER
        if counts and rise[worst] >= least:
            break
        support = np.delete(support, worst)
    return support


def exchange_for_simpler(
    gram: Gram, support: Sequence[int] | np.ndarray, cost: np.ndarray, n_free: np.ndarray
) -> np.ndarray:
    """Exchange terms for cheaper ones that fit as well.

    Parameters
    ----------
    gram : Gram
        Inner products; columns should have similar sizes.
    support : sequence of int
        Columns to begin with.
    cost : ndarray of shape (p,)
        Price of each column.
    n_free : ndarray of int of shape (p,)
        Inner constants of each column.

    Returns
    -------
    ndarray of int
        As many columns. The most expensive one is exchanged first.

    Notes
    -----
    Where q is small, noise in the variables makes v/(1 + q v) fit a little better than v. A cheaper
    term takes its place if the error rises by at most a hundredth of itself and of the gain of the
    term. A free constant also fits the smooth error of a finite difference, so a term with fewer
    constants only has to fit within the accuracy of a derivative, see `drop_immaterial`. An
    equation that leaves nothing but rounding is kept as it is.
    """
    chosen = list(support)
    for j in sorted(support, key=lambda column: -cost[column]):
        error = rss(gram, least_squares(gram, chosen))
        if error <= PERFECT * gram.yy:
            break
        rest = [i for i in chosen if i != j]
        gain = rss(gram, least_squares(gram, rest)) - error
        exchanged = gains(gram, rest)[0]
        as_good = exchanged - error <= REMAINDER * min(error, gain)
        as_good |= (n_free < n_free[j]) & (exchanged <= max(error, MATERIAL * gram.yy))
        as_good[chosen] = False
        options = [chosen, *([*rest, int(i)] for i in np.flatnonzero(as_good))]
        chosen = min(options, key=lambda columns: _total_price(gram, columns, cost))
    return np.array(sorted(chosen), dtype=int)


def _total_price(gram: Gram, support: Sequence[int], cost: np.ndarray) -> float:
    """Return the price of an equation; terms that nearly cancel each other cost more."""
    coef = least_squares(gram, support)[support]
    size = np.abs(coef) * np.sqrt(np.diag(gram.xx)[support] / gram.yy)
    return float(np.sum(cost[support] + 2.0 * np.log(np.maximum(size, 1.0))))


def drop_unstable(
    whole: Gram, folds: Sequence[Gram], support: Sequence[int] | np.ndarray, min_ratio: float = 3.0
) -> np.ndarray:
    """Drop terms whose coefficient scatters too much between parts of the record.

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
        The rest of the support.

    Notes
    -----
    The standard error is the jackknife's over blocks, which holds for autocorrelated residuals as
    long as blocks are longer than their memory. The weakest term is dropped first.
    A term that shows in one part of the record only, such as a stiffness in a resonance or a growth
    before a limit cycle, scatters much, as nothing determines it without that part. It stays if it
    explains a hundredth of the target's power, or if it exceeds six standard errors with rows taken
    as independent.
    """
    support = np.asarray(support, dtype=int)
    while len(support):
        ratio = _jackknife_ratio(whole, folds, support)
        ratio[_dominant(whole, support)] = np.inf
        ratio[_shown_at_once(whole, folds, support)] = np.inf
        worst = int(np.argmin(ratio))
        if ratio[worst] >= min_ratio:
            break
        support = np.delete(support, worst)
    return support


def _dominant(whole: Gram, support: np.ndarray) -> np.ndarray:
    """Tell which terms explain so much that they stay, wherever in the record they show."""
    scaled = whole.scaled(whole.scale)
    error = rss(scaled, least_squares(scaled, support))
    rise = gains(scaled, support)[1][support] - error
    return np.asarray(rise >= max(DOMINANT * whole.yy, 0.1 * error))


def _shown_at_once(whole: Gram, folds: Sequence[Gram], support: np.ndarray) -> np.ndarray:
    """Tell which terms are determined mostly by one block, and are significant."""
    inverted = inverse(whole.select(support))
    contrast = inverted / np.diag(inverted)  # theta @ contrast: each column less all others
    power = 1.0 / np.diag(inverted)
    xx = [(whole - fold).xx[np.ix_(support, support)] for fold in folds]
    largest = np.max([np.einsum("ij,ik,kj->j", contrast, part, contrast) for part in xx], axis=0)
    coef = least_squares(whole, support)
    noise = rss(whole, coef) / max(whole.n - len(support), 1)
    size = np.abs(coef[support]) * np.sqrt(power / max(noise, np.finfo(float).tiny))
    return np.asarray((largest > 0.5 * power) & (size > MIN_STANDARD_ERRORS))


def _jackknife_ratio(whole: Gram, folds: Sequence[Gram], support: np.ndarray) -> np.ndarray:
    coef = np.array([least_squares(fold, support)[support] for fold in folds])
    count = len(folds)
    error = np.sqrt((count - 1) / count * ((coef - coef.mean(axis=0)) ** 2).sum(axis=0))
    size = np.abs(least_squares(whole, support)[support])
    return size / np.maximum(error, np.finfo(float).tiny)
