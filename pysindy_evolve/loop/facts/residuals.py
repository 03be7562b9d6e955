"""The residual of a model: the part of the measured derivative that it does not explain."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...equations import Equations
from ...hidden_states.memory_equations import as_acting
from ...signals import Record
from ..fitting.past import rates_on
from ..given.sensor import as_observed

# Standard deviation over RMS of a derivative; below it, its variation is rounding.
MIN_RELATIVE_SPREAD = 1e-6


def residual_of(equations: Equations, record: Record) -> np.ndarray:
    """Return x_dot minus the model, (n_samples, n_states); zero on rows that are not all `seen`."""
    equations, record = as_acting(equations, record)
    return as_observed(record, record.x_dot - rates_on(equations, record))


def percent_left(equations: Equations, records: Sequence[Record]) -> np.ndarray:
    """Return the RMS residual of each derivative, percent of its standard deviation."""
    residuals = np.concatenate([residual_of(equations, record) for record in records])
    return in_percent(residuals, records)


def in_percent(columns: np.ndarray, records: Sequence[Record]) -> np.ndarray:
    """Return the RMS of columns (n_samples, n_states) in percent.

    Percent of the standard deviation of the measured derivatives. NaN where a derivative hardly
    varies, as that of a ramp: a share of rounding means nothing.
    """
    rates = np.concatenate([record.x_dot for record in records])
    spread, size = rates.std(axis=0), np.sqrt(np.mean(rates**2, axis=0))
    scale = np.where(spread > MIN_RELATIVE_SPREAD * size, spread, np.nan)
    return np.asarray(100.0 * np.sqrt(np.nanmean(columns**2, axis=0)) / scale)
