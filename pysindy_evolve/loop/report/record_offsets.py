"""Offsets that differ between records, such as a load or the zero of a sensor.

What stays within a record and is another one in the next can be no fixed term, so it stays without
a name; but a model that leaves it is not complete.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .residuals import residual_of

if TYPE_CHECKING:
    from .report import LoopReport

__all__ = ["offsets_by_record"]

N_BLOCKS = 8  # of a record, whose means tell how well its own is known
SURE = 6.0  # standard errors, of which there are few blocks to know them from
MOST = 0.5  # share of what is left of a derivative


def offsets_by_record(report: LoopReport) -> dict[str, np.ndarray]:
    """Return the mean residual in each training record, of states where it is not the same.

    Units of the state per unit of t. Empty of a single record, and of algebraic targets.
    """
    model, records = report.after.model, report.train
    if len(records) < 2 or model.n_algebraic:
        return {}
    left = [residual_of(model, record) for record in records]
    blocks = [np.array([b.mean(axis=0) for b in np.array_split(one, N_BLOCKS)]) for one in left]
    means = np.array([one.mean(axis=0) for one in blocks])
    errors = np.array([one.std(axis=0, ddof=1) for one in blocks]) / np.sqrt(N_BLOCKS)
    apart = np.abs(means - means.mean(axis=0))
    power = np.mean([np.mean(one**2, axis=0) for one in left], axis=0)
    differ = np.any(apart > SURE * errors, axis=0) & (means.var(axis=0) > MOST * power)
    return {model.states[k]: means[:, k] for k in report.design.open_states if differ[k]}
