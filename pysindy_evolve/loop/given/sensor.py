"""Runs seen through a sensor of limited range.

Where a sensor shows its limit, every run beyond the limit agrees with it, and the derivatives of
the reading mean nothing. So runs and records are compared through the same sensor.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...signals import Record


def limits_of_states(records: Sequence[Record]) -> np.ndarray | None:
    """Return the limits of sensors beyond which states went on unseen, as `ends_of` does."""
    return ends_of([record for record in records if record.seen is not None])


def ends_of(records: Sequence[Record]) -> np.ndarray | None:
    """Return the lower and upper limit of the readings of each state, shape (2, n_states).

    Common to all records; infinite where there is no reading or limit. None if there is no limit.
    """
    made = [record.preparation for record in records if record.preparation is not None]
    if (
        not made
        or len(made) < len(records)
        or not any(np.isfinite(one.limits).any() for one in made)
    ):
        return None
    limits = np.array([[-np.inf], [np.inf]]) * np.ones(records[0].n_states)
    order, n_columns = made[0].order, made[0].limits.shape[1]
    read = slice(0, order * n_columns, order)  # hidden states come after the measured ones
    limits[0, read] = np.max([one.limits[0] for one in made], axis=0)
    limits[1, read] = np.min([one.limits[1] for one in made], axis=0)
    return limits


def shown(x: np.ndarray, limits: np.ndarray | None) -> np.ndarray:
    """Return states (..., n_states) as sensors with limits show them."""
    return x if limits is None else np.clip(x, *limits)


def is_observed(x: np.ndarray, limits: np.ndarray | None, seen: np.ndarray | None) -> np.ndarray:
    """Tell which states (..., n_states) of a run a sensor shows: bool of the same shape.

    Parameters
    ----------
    x : ndarray of shape (..., n_states)
        The run.
    limits : ndarray of shape (2, n_states) or None
        Limits of the sensors.
    seen : ndarray of bool of shape (..., n_states) or None
        Where the record is a measurement.
    """
    visible = np.ones(x.shape, dtype=bool)
    if limits is None:
        return visible
    read = np.isfinite(limits).any(axis=0)  # a reading tells something even at a limit
    if seen is not None:
        visible &= seen | read
    return np.asarray(visible & ~(x < limits[0]) & ~(x > limits[1]))


def miss_of_run(
    x: np.ndarray, run: np.ndarray, limits: np.ndarray | None, seen: np.ndarray | None
) -> np.ndarray:
    """Return measured minus simulated states, (..., n_states), both as sensors show them."""
    if limits is None:
        return np.asarray(x - run)
    read = np.isfinite(limits).any(axis=0)
    difference = shown(x, limits) - shown(run, limits)
    return difference if seen is None else np.where(seen | read, difference, 0.0)


def as_observed(record: Record, columns: np.ndarray) -> np.ndarray:
    """Return columns (n_samples, ...) of a record, zero where a sensor does not see its state."""
    if record.seen is None:
        return columns
    all_seen = np.all(record.seen, axis=1)
    return np.asarray(np.where(all_seen[:, None], columns, 0.0))
