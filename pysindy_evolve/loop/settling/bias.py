"""Take off what the noise of the sensor does to coefficients.

A filtered velocity turns more slowly than the machine did, so sgn of it explains less, and least
squares make the friction too small. Twins of the corrected model are measured and filtered alike,
and in them the coefficients are known: by what their fit misses them, so does the fit of the
record. Where a twin cannot be measured from raw data, nothing is known about this, or taken off;
nor is it where the record says that the coefficients were better before.

References
----------
Efron and Tibshirani, An Introduction to the Bootstrap (1993), chapter 10.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from joblib import Parallel, delayed

from ...signals import Record
from ..fitting.fit import Fit, refit
from ..fitting.runs import stretch_misses
from ..given.design import Design
from ..twins.twins import TwinMaker

N_TWINS = 16
MIN_STANDARD_ERRORS = 2.0  # standard errors of the mean over the twins, from which on a bias is one
NORMAL = 1.96  # standard deviations to each side that hold 95 %
NO_WORSE = 1.05  # times the square of the simulation error that they may show afterwards


def unbiased(
    design: Design,
    fitted: Fit,
    records: Sequence[Record],
    rng: np.random.Generator,
    n_jobs: int | None = None,
) -> Fit:
    """Return a fit without the bias that its own twins show.

    Parameters
    ----------
    design : Design
        The model, with p columns.
    fitted : Fit
        Its coefficients on the records.
    records : sequence of Record
        Training records.
    rng : numpy.random.Generator
        Draws the twins.
    n_jobs : int, optional
        Processes that work on the twins.

    Returns
    -------
    Fit
        The same fit where a record was not made from raw data, or does not bear the bias out.
    """
    maker = TwinMaker.of(design.equations(fitted.coef), records)
    if not design.columns or any(path is None for path in maker.simulated):
        return fitted
    refits = Parallel(n_jobs=n_jobs)(
        delayed(_refitted)(maker, design, fitted.criterion, child) for child in rng.spawn(N_TWINS)
    )
    coefs = np.array(refits)
    spread = coefs.std(axis=0, ddof=1)
    bias = coefs.mean(axis=0) - fitted.coef
    bias = np.where(np.abs(bias) > MIN_STANDARD_ERRORS * spread / np.sqrt(N_TWINS), bias, 0.0)
    coef, intervals = fitted.coef - bias, fitted.intervals - bias[:, None]
    before, after = (stretch_misses(design.equations(c), records) for c in (fitted.coef, coef))
    if not after <= NO_WORSE * before:
        return fitted
    # Twins do not know how the model fails, blocks of the record not how the filter does.
    low = np.minimum(intervals[:, 0], coef - NORMAL * spread)
    high = np.maximum(intervals[:, 1], coef + NORMAL * spread)
    return replace(fitted, coef=coef, intervals=np.column_stack([low, high]))


def _refitted(
    maker: TwinMaker, design: Design, criterion: str, rng: np.random.Generator
) -> np.ndarray:
    return refit(design, maker.make(rng), criterion)
