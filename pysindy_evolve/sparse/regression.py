"""Sparse regression on Gram matrices, symbols as in `gram`: what proposes terms.

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
    "LAMBDA2", "Gram", "block_grams", "default_penalty", "effective_size",
    "elastic_net", "eliminate", "front", "gains", "gram", "information",
    "least_squares", "path", "prune", "refined", "residual", "rss",
    "supports", "target_grams", "total",
]  # fmt: skip

FORWARD = 6  # steps of forward selection beside the elastic net
LAMBDA2 = (1e-3, 1e-1)  # relative to columns of unit RMS; orders of magnitude are enough


def elastic_net(gram: Gram, lambda1: float, lambda2: float, max_iter: int = 10_000) -> np.ndarray:
    """Minimize ||theta coef - y||^2 + lambda1 ||coef||_1 + lambda2 ||coef||^2, equation (11).

    Parameters
    ----------
    gram : Gram
        Inner products.
    lambda1, lambda2 : float
        Weights of the penalties, at least zero.
    max_iter : int
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
    for _ in range(max_iter):
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
        f"ElasticNet(max_iter=...) should be larger: after {max_iter} sweeps a coefficient "
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
