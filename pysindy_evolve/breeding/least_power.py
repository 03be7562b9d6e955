"""The least sum of squares that a term must explain, given the noise in the variables.

Noise e in the variables moves theta(x) @ coef by about grad(theta @ coef) @ e. A false term, made
up from noise, explains a part of that movement and never more. So a term that explains less than
`MIN_EXPLAINED_SHARE` of it is rejected, even if it is significant.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..terms import Cache, Product
from .dictionary import Problem

# Of the movement's power; false terms on simulated rigs explained less than 0.2.
MIN_EXPLAINED_SHARE = 0.3
N_ROWS = 10_000  # about how many rows the mean is taken over


def least_explained_power(
    problem: Problem, terms: Sequence[Product], coef: Sequence[float]
) -> float:
    """Return the sum of squares that a term must explain.

    Parameters
    ----------
    problem : Problem
        All rows, and the noise of each variable.
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
    every = slice(None, None, max(len(problem.x) // N_ROWS, 1))
    x, noise = problem.x[every], np.broadcast_to(problem.noise, problem.x.shape)[every]
    moved = 0.0
    for j in np.flatnonzero(noise.any(axis=0)):
        step = noise * (np.arange(x.shape[1]) == j)
        slope = 0.5 * (_sum(x + step, terms, coef) - _sum(x - step, terms, coef))
        moved += float(np.mean(slope**2, where=np.isfinite(slope)))
    return MIN_EXPLAINED_SHARE * moved * len(problem.x)


def _sum(x: np.ndarray, terms: Sequence[Product], coef: Sequence[float]) -> np.ndarray:
    cache: Cache = {}
    with np.errstate(all="ignore"):
        columns = [c * term.evaluate(x, cache) for term, c in zip(terms, coef, strict=True)]
    return np.sum(columns, axis=0) if columns else np.zeros(len(x))
