"""What a model leaves of the measured derivative of a record."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...equations import Equations
from ...hidden_states.memory_equations import as_acting
from ...signals import Record
from ..fitting.past import rates_on
from ..given.sensor import as_observed

__all__ = ["in_percent", "percent_left", "residual_of"]

STEADY = 1e-6  # of its size, that a derivative varies by if only rounding or noise is in it


def residual_of(equations: Equations, record: Record) -> np.ndarray:
    """Return x_dot minus the model, (n_samples, n_states); zero where no sensor saw the state."""
    equations, record = as_acting(equations, record)
    return as_observed(record, record.x_dot - rates_on(equations, record))


def percent_left(equations: Equations, records: Sequence[Record]) -> np.ndarray:
    """Return what is left of each derivative of records, percent of its standard deviation."""
    left = np.concatenate([residual_of(equations, record) for record in records])
    return in_percent(left, records)


def in_percent(columns: np.ndarray, records: Sequence[Record]) -> np.ndarray:
    """Return the RMS of columns (n_samples, n_states), percent of what the derivatives vary by.

    NaN where a derivative hardly varies, as that of a ramp: no share of rounding says anything.
    """
    rates = np.concatenate([record.x_dot for record in records])
    spread, size = rates.std(axis=0), np.sqrt(np.mean(rates**2, axis=0))
    scale = np.where(spread > STEADY * size, spread, np.nan)
    return np.asarray(100.0 * np.sqrt(np.nanmean(columns**2, axis=0)) / scale)
