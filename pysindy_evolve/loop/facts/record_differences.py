"""What differs between records: a load, the zero of a sensor, a friction that falls as it warms up.

Each record by itself is then explained well, but no fixed value explains all of them together. No
fixed term can be constant within a record and differ in the next, so such an offset gets no name;
but a model that leaves it in the residual is not complete.
"""

from __future__ import annotations

import numpy as np
from scipy.stats import studentized_range

from ...hidden_states.memory_equations import as_acting
from ..fitting.fit import derivative_square, refit
from ..given.rows import variables_of
from .outcome import Outcome
from .residuals import residual_of

LESS_SQUARE = 0.8  # largest ratio of squared errors, with a value for each record over common ones
REACH_OF_95 = 3.92  # width of a 95 % interval, in standard deviations
SURE = 0.995  # chance with which the same parameter lies closer together
SAME = 0.01  # relative spread of a parameter below which the records count as the same
MIN_CHANGE_SHARE = 0.5  # share of the largest change of the rates by any parameter that differs
N_BLOCKS = 8  # blocks of a record; the scatter of their means gives the standard error of its mean
MIN_STANDARD_ERRORS = 6.0  # standard errors; so many, as they are estimated from eight blocks only
LEAST_SHARE = 0.5  # share of the mean square of the residual that the offsets must make up


def numbers_by_record(outcome: Outcome) -> dict[str, np.ndarray]:
    """Return the parameters that differ between the training records, with a value for each.

    Only those that change the rates most. Empty for a single record, and where common values fit
    nearly as well. Only declared parameters, as two effects may have the same name.
    """
    design = outcome.design
    if len(outcome.train) < 2 or not design.columns:
        return {}
    records = [as_acting(outcome.equations, record)[1] for record in outcome.train]
    pooled = refit(design, records, "derivative")
    each = np.array([refit(design, [record], "derivative") for record in records])
    fits = zip(records, each, strict=True)
    square = sum(derivative_square(design, [record], coef) for record, coef in fits)
    if square >= LESS_SQUARE * derivative_square(design, records, pooled):
        return {}
    sizes = [
        np.sqrt(np.mean([np.mean(c.evaluate(variables_of(r)) ** 2) for r in records]))
        for c in design.columns
    ]
    spreads = np.ptp(each, axis=0) * np.array(sizes)
    return {
        column.name: each[:, k]
        for k, column in enumerate(design.columns)
        if column.name.isidentifier()
        and column.name in outcome.before.parameters
        and spreads[k] >= MIN_CHANGE_SHARE * spreads.max()
        and np.ptp(each[:, k]) > _spread_by_chance(outcome, column.name)
        and np.ptp(each[:, k]) > SAME * np.abs(each[:, k]).max()
    }


def _spread_by_chance(outcome: Outcome, name: str) -> float:
    """Return the spread between records that chance gives a parameter that is the same in all.

    The interval of a single record is sqrt(n_records) times as wide as that of all. How far the
    largest and the smallest of n draws lie apart is the studentized range.
    """
    n_records = len(outcome.train)
    low, high = outcome.after.parameter_intervals.get(name, np.zeros(2))
    deviation = float(high - low) * np.sqrt(n_records) / REACH_OF_95
    return deviation * float(studentized_range.ppf(SURE, n_records, np.inf))


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
