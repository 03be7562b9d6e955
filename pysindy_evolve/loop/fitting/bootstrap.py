"""Intervals of coefficients from blocks of rows, which respect autocorrelated residuals.

Each block gets a random weight. Blocks drawn with replacement could all miss the few in which a
stop was hit, and so allow a stiffness of zero. If few blocks determine a coefficient, its spread is
uncertain too, so its interval is widened, as Student's t is for few measurements.

References
----------
Rubin, Ann. Statist. 9 (1981), DOI 10.1214/aos/1176345338: the Bayesian bootstrap. Imbens and
Kolesár, Rev. Econ. Stat. 98 (2016), DOI 10.1162/REST_a_00552: degrees of freedom where few
clusters tell most.
"""

from __future__ import annotations

import numpy as np
from scipy import stats

from ...checks import TINY
from .linear import solve_gram, solve_many

N_RESAMPLES = 400
CHANCES = (0.025, 0.975)
# Degrees of freedom: if one block tells a number, its interval is 200 times as wide.
MIN_DEGREES_OF_FREEDOM = 0.5


def block_intervals(grams: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Return the 95 % intervals of the coefficients that fit blocks of rows.

    Parameters
    ----------
    grams : ndarray of shape (n_blocks, p + 1, p + 1)
        Inner products of columns and, last, target in each block.
    rng : numpy.random.Generator
        Draws the weights of the blocks.

    Returns
    -------
    ndarray of shape (p, 2)
    """
    weights = rng.standard_exponential((N_RESAMPLES, len(grams)))
    coefs = [solve_gram(gram) for gram in np.tensordot(weights, grams, axes=1)]
    ends = np.quantile(coefs, CHANCES, axis=0)
    middle, freedom = solve_gram(grams.sum(axis=0)), _freedom(grams)
    # Random weights of n blocks give only sqrt((n - 1) / (n + 1)) of the true spread.
    wider = stats.t.ppf(CHANCES[1], freedom) / stats.norm.ppf(CHANCES[1])
    wider = wider * np.sqrt((freedom + 2.0) / freedom)
    return np.asarray((middle + wider * (ends - middle)).T)


def _freedom(grams: np.ndarray) -> np.ndarray:
    """Return the effective number of blocks that determine each coefficient, less one."""
    columns = grams[:, :-1, :-1]
    weights = solve_many(columns.sum(axis=0), np.eye(columns.shape[-1]))
    information = np.maximum(np.einsum("ij,bik,kj->bj", weights, columns, weights), 0.0)
    shares = information / np.maximum(information.sum(axis=0), TINY)
    return np.maximum(
        1.0 / np.maximum(np.sum(shares**2, axis=0), TINY) - 1.0, MIN_DEGREES_OF_FREEDOM
    )
