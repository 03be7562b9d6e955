"""Inner constants by variable projection: the outer coefficients are solved, the inner searched.

x/(c + x), sin(w x) and exp(-x/c) are linear in nothing. For given inner constants the outer
coefficients are least squares, so only the inner ones are left to search (Golub and Pereyra,
SIAM J. Numer. Anal. 10, 1973, doi:10.1137/0710036).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from scipy.optimize import least_squares

from .terms import Product

__all__ = ["tune"]

FACTORS = (0.1, 0.25, 0.5, 2.0, 4.0, 10.0)  # a coarse look around before the local search


def tune(
    terms: Sequence[Product],
    x: np.ndarray,
    y: np.ndarray,
    others: np.ndarray,
    *,
    project: Callable[[np.ndarray], np.ndarray] | None = None,
    scan: bool = True,
) -> tuple[Product, ...]:
    """Choose the inner constants of terms so that least squares on all columns fits best.

    Parameters
    ----------
    terms : sequence of Product
        Terms whose constants are free.
    x : ndarray of shape (n, n_variables)
        Variables.
    y : ndarray of shape (m,)
        Target, projected if `project` is given.
    others : ndarray of shape (m, k)
        The other columns of the equation, projected if `project` is given.
    project : callable, optional
        Linear map on the rows of columns, (n, p) to (m, p).
    scan : bool
        Look at multiples of each constant first.

    Returns
    -------
    tuple of Product
        Never a worse fit than with the constants given.
    """
    start = np.array([c for term in terms for c in term.constants])
    if not len(start):
        return tuple(terms)
    basis = np.linalg.qr(others)[0] if others.shape[1] else others
    y = y - basis @ (basis.T @ y)

    def residual(constants: np.ndarray) -> np.ndarray:
        columns = np.column_stack([t.evaluate(x) for t in _with(terms, constants)])
        if not np.isfinite(columns).all():
            return y
        columns = columns if project is None else project(columns)
        columns = columns - basis @ (basis.T @ columns)
        size = np.sqrt(np.einsum("ij,ij->j", columns, columns))
        columns = columns / np.where(size > 0.0, size, 1.0)
        return y - columns @ np.linalg.lstsq(columns, y, rcond=1e-10)[0]

    def error(constants: np.ndarray) -> float:
        value = residual(constants)
        return float(value @ value)

    first = min(_around(start) if scan else [start], key=error)
    found = least_squares(residual, first, x_scale=np.maximum(np.abs(first), 1e-12), max_nfev=12).x
    # A constant that is tuned away leaves another term, one that the search knows as its own.
    kept = [c for c in (first, found) if np.all(np.abs(c) > 1e-6 * np.abs(start))]
    best = min((start, *kept), key=error)
    return _with(terms, best)


def _around(start: np.ndarray) -> list[np.ndarray]:
    """Return the start and variants of it with one constant multiplied."""
    variants = [start]
    for i in range(len(start)):
        for factor in FACTORS:
            variant = start.copy()
            variant[i] *= factor
            variants.append(variant)
    return variants


def _with(terms: Sequence[Product], constants: np.ndarray) -> tuple[Product, ...]:
    rest = iter(constants)
    return tuple(t.with_constants([float(next(rest)) for _ in t.constants]) for t in terms)
