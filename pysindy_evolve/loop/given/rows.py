"""Rows of records: states, inputs and time side by side, and what expressions make of them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...equations import stack
from ...signals import Record
from ...terms import Sum

MAX_TERM_VALUE = 1e100  # value of a term: its square is finite, and so is the cube of a large state


def variables_of(record: Record) -> np.ndarray:
    """Return states, inputs and time side by side, shape (n_samples, n_variables)."""
    return stack(record.x, record.u, record.t)


def rows_of(records: Sequence[Record]) -> np.ndarray:
    """Return the variables of several records, one record below the other."""
    return np.concatenate([variables_of(record) for record in records])


def have_values(expressions: Sequence[Sum], records: Sequence[Record]) -> bool:
    """Tell whether expressions have a finite value, and no huge one, on every row of records."""
    rows = [variables_of(record) for record in records]
    with np.errstate(all="ignore"):
        values = (one.evaluate(z) for one in expressions for z in rows)
        return all(bool((np.abs(value) < MAX_TERM_VALUE).all()) for value in values)


def scale_of(parts: Sequence[np.ndarray]) -> np.ndarray:
    """Return the standard deviation of each column over all parts; one where nothing changes."""
    scale = np.concatenate(parts).std(axis=0)
    return np.where(scale > 0.0, scale, 1.0)
