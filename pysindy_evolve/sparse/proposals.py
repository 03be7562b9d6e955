"""Which terms may belong together: supports from elastic nets and from forward selection.

The elastic net, equation (11) of the paper, only proposes: besides the true terms it keeps others
that correlate with them. Elimination decides, see `selection`. Symbols as in `gram`.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence

import numpy as np
from sklearn.exceptions import ConvergenceWarning
from sklearn.linear_model import lars_path_gram

from .elimination import gains
from .gram import MIN_SQUARE_SHARE, Gram

FORWARD = 6  # steps of forward selection beside the elastic net
LAMBDA2 = (1e-3, 1e-1)  # for columns of unit RMS; orders of magnitude are enough


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
        The largest support of each path, one of half its size, and that of forward selection, a
        shorter way where all terms are nearly collinear, as on a closed orbit.
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
        if with_column[support[-1]] <= 2.0 * MIN_SQUARE_SHARE * gram.yy:
            break
    return np.array(sorted(set(support)), dtype=int)
