"""Sparse regression on Gram matrices, symbols as in `gram`: what proposes and what accepts terms.

The elastic net, equation (11) of the paper, proposes supports; backward elimination by an
information criterion chooses among them; least squares decides the coefficients. An elastic net
alone never gives the exact support: it keeps shadows of the true terms.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence

import numpy as np
from sklearn.exceptions import ConvergenceWarning
from sklearn.linear_model import lars_path_gram

from .elimination import default_penalty, eliminate, front, gains, information, prune
from .gram import (
    LEAST,
    Gram,
    block_grams,
    gram,
    least_squares,
    refined,
    residual,
    rss,
    target_grams,
    total,
)  # fmt: skip
from .independence import effective_size

# Elimination and Gram matrices are part of the regression for those who use it.
__all__ = [
    "LAMBDA2", "PERFECT", "Gram", "block_grams", "default_penalty", "effective_size",
    "elastic_net", "eliminate", "front", "frugal", "gains", "gram", "information",
    "least_squares", "material", "path", "plainer", "prune", "refined", "residual", "rss",
    "stable", "supports", "target_grams", "total",
]  # fmt: skip

PERFECT = 1e-11  # share of the target's power at which there is nothing left to explain
MATERIAL = 1e-5  # share of the target's power: no derivative is good to better than 0.3 %
DOMINANT = 1e-2  # share of the target's power that no chance correlation explains
REMAINDER = 1e-2  # share of the error that a smaller term may leave, if it is to count
FORWARD = 6  # steps of forward selection beside the elastic net
LAMBDA2 = (1e-3, 1e-1)  # relative to columns of unit RMS; orders of magnitude are enough


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


def material(gram: Gram, support: Sequence[int] | np.ndarray, least: float = 0.0) -> np.ndarray:
    """Drop terms too small to be told from the error of a derivative.

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
        seen = error + rise[worst] >= MATERIAL * gram.yy or rise[worst] >= error / REMAINDER
        if seen and rise[worst] >= least:
            break
        support = np.delete(support, worst)
    return support


def plainer(gram: Gram, support: Sequence[int] | np.ndarray, n_free: np.ndarray) -> np.ndarray:
    """Exchange terms with inner constants for others that fit as well as a derivative is known.

    Parameters
    ----------
    gram : Gram
        Inner products.
    support : sequence of int
        Columns to begin with.
    n_free : ndarray of int of shape (p,)
        Inner constants of each column; an exchange makes them fewer.

    Returns
    -------
    ndarray of int
        As many columns; see `material` for the reason and the measure.

    Notes
    -----
    A constant that is free takes up the smooth error of a finite difference: x cos(0.007 x) fits it
    better than x. An equation that leaves nothing but rounding is kept as it is.
    """
    chosen = list(support)
    for j in [column for column in support if n_free[column]]:
        error = rss(gram, least_squares(gram, chosen))
        rest = [i for i in chosen if i != j]
        instead = gains(gram, rest)[0]
        able = (n_free < n_free[j]) & (instead <= max(error, MATERIAL * gram.yy))
        able[chosen] = False
        if able.any() and error > PERFECT * gram.yy:
            chosen = [*rest, int(np.argmin(np.where(able, instead, np.inf)))]
    return np.array(sorted(chosen), dtype=int)


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
    A term that shows in one part of the record only, as a stiffness does in a resonance, has no
    small scatter; it stays if it alone explains a hundredth of the target's power.
    """
    support = np.asarray(support, dtype=int)
    while len(support):
        ratio = _jackknife_ratio(whole, folds, support)
        ratio[_dominant(whole, support)] = np.inf
        worst = int(np.argmin(ratio))
        if ratio[worst] >= min_ratio:
            break
        support = np.delete(support, worst)
    return support


def _dominant(whole: Gram, support: np.ndarray) -> np.ndarray:
    """Tell which terms the equation cannot be without, wherever in the record they show."""
    scaled = whole.scaled(whole.scale)
    error = rss(scaled, least_squares(scaled, support))
    rise = gains(scaled, support)[1][support] - error
    return np.asarray(rise >= max(DOMINANT * whole.yy, 0.1 * error))


def _jackknife_ratio(whole: Gram, folds: Sequence[Gram], support: np.ndarray) -> np.ndarray:
    coef = np.array([least_squares(fold, support)[support] for fold in folds])
    count = len(folds)
    error = np.sqrt((count - 1) / count * ((coef - coef.mean(axis=0)) ** 2).sum(axis=0))
    size = np.abs(least_squares(whole, support)[support])
    return size / np.maximum(error, np.finfo(float).tiny)
