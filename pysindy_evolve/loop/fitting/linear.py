"""Normal equations, solved without harm from columns of very different size."""

from __future__ import annotations

import numpy as np

__all__ = ["RIDGE", "TINY", "log_ratio", "solve", "solve_gram", "solve_many"]

TINY = 1e-300  # what nothing is divided by less than
RIDGE = 1e-10  # relative; keeps a column that repeats another one from blowing up


def solve(xx: np.ndarray, xy: np.ndarray) -> np.ndarray:
    """Solve normal equations, with columns brought to one size first.

    Parameters
    ----------
    xx : ndarray of shape (..., p, p)
        Inner products of the columns.
    xy : ndarray of shape (..., p)
        Inner products with the target.

    Returns
    -------
    ndarray of shape (..., p)
    """
    return solve_many(xx, xy[..., None])[..., 0]


def solve_many(xx: np.ndarray, xy: np.ndarray) -> np.ndarray:
    """Solve normal equations for several targets, with columns brought to one size first.

    Parameters
    ----------
    xx : ndarray of shape (..., p, p)
        Inner products of the columns.
    xy : ndarray of shape (..., p, n_targets)
        Inner products with the targets.

    Returns
    -------
    ndarray of shape (..., p, n_targets)
    """
    size = np.sqrt(np.maximum(np.diagonal(xx, axis1=-2, axis2=-1), TINY))[..., None]
    scaled = xx / (size * np.swapaxes(size, -1, -2)) + RIDGE * np.eye(xx.shape[-1])
    return np.asarray(np.linalg.solve(scaled, xy / size) / size)


def solve_gram(gram: np.ndarray) -> np.ndarray:
    """Return the coefficients that fit the last column of a Gram matrix by the others.

    Parameters
    ----------
    gram : ndarray of shape (p + 1, p + 1)
        Inner products of the columns and, last, the target.

    Returns
    -------
    ndarray of shape (p,)
    """
    return solve(gram[:-1, :-1], gram[:-1, -1])


def log_ratio(before: float, after: float) -> float:
    """Return log(before / after) of two errors; finite where one of them is zero."""
    return float(np.log(max(before, TINY) / max(after, TINY)))
