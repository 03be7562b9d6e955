"""What noise in the variables does to an equation, and so what a term must be worth.

Noise e in the variables moves theta(x) @ coef by about grad(theta @ coef) @ e. A term that is made
up from noise explains part of that movement and never more than it; a term that explains less than
a fair share of it is not believed, however many rows agree on it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..terms import Cache, Product
from .dictionary import Problem

__all__ = ["blurred_power"]

SHARE = 0.3  # of the movement that false terms explain at most; on simulated rigs below 0.2
ROWS = 10_000  # are enough for a mean


def blurred_power(problem: Problem, terms: Sequence[Product], coef: Sequence[float]) -> float:
    """Return the sum of squares that a term must explain.

    Parameters
    ----------
    problem : Problem
        All rows; its `noise` says how uncertain each variable is.
    terms : sequence of Product
        An equation.
    coef : sequence of float
        Its coefficients, in units of the target per unit of the term.

    Returns
    -------
    float
        In units of the target squared, for all rows; zero where the variables have no noise.
    """
    if problem.noise is None or not np.any(problem.noise):
        return 0.0
    x = problem.x[:: max(len(problem.x) // ROWS, 1)]
    moved = 0.0
    for j in np.flatnonzero(problem.noise):
        step = problem.noise * (np.arange(x.shape[1]) == j)
        slope = 0.5 * (_sum(x + step, terms, coef) - _sum(x - step, terms, coef))
        moved += float(np.mean(slope**2, where=np.isfinite(slope)))
    return SHARE * moved * len(problem.x)


def _sum(x: np.ndarray, terms: Sequence[Product], coef: Sequence[float]) -> np.ndarray:
    cache: Cache = {}
    with np.errstate(all="ignore"):
        columns = [c * term.evaluate(x, cache) for term, c in zip(terms, coef, strict=True)]
    return np.sum(columns, axis=0) if columns else np.zeros(len(x))
