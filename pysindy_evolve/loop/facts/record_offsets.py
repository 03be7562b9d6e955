"""Offsets that differ between records, such as a load or the zero of a sensor.

No fixed term can be constant within a record and differ in the next, so such an offset gets no
name; but a model that leaves it in the residual is not complete.
"""

from __future__ import annotations

import numpy as np

from .outcome import Outcome
from .residuals import residual_of

__all__ = ["offsets_by_record"]

N_BLOCKS = 8  # blocks of a record; the scatter of their means gives the standard error of its mean
MIN_STANDARD_ERRORS = 6.0  # standard errors; so many, as they are estimated from eight blocks only
LEAST_SHARE = 0.5  # share of the mean square of the residual that the offsets must make up


def offsets_by_record(outcome: Outcome) -> dict[str, np.ndarray]:
    """Return the mean residual in each training record, for the states where it differs.

    Units of the state per unit of t. Empty for a single record, and for algebraic targets.
    """
    model, records = outcome.after.model, outcome.train
    if len(records) < 2 or model.n_algebraic:
        return {}
    residuals = [residual_of(model, record) for record in records]
    blocks = [
        np.array([block.mean(axis=0) for block in np.array_split(rows, N_BLOCKS)])
        for rows in residuals
    ]
    means = np.array([rows.mean(axis=0) for rows in blocks])
    errors = np.array([rows.std(axis=0, ddof=1) for rows in blocks]) / np.sqrt(N_BLOCKS)
    deviation = np.abs(means - means.mean(axis=0))
    power = np.mean([np.mean(rows**2, axis=0) for rows in residuals], axis=0)
    is_sure = np.any(deviation > MIN_STANDARD_ERRORS * errors, axis=0)
    differs = is_sure & (means.var(axis=0) > LEAST_SHARE * power)
    return {model.states[k]: means[:, k] for k in outcome.design.open_states if differs[k]}
