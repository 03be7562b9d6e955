"""Inputs that are held from each sample to the next (zero-order hold), as a controller does.

What is recorded at a sample begins there and ends at the next one. Between the samples a record is
taken to run smoothly, so such an input acts half a sample later than it seems to; and one that may
jump at any time between two samples is late by its own share of one.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from scipy.interpolate import CubicSpline

from .record import Record
from .spectral import Array

__all__ = ["HALF", "hold"]

HALF = 0.5  # sampling times by which a held input is late


def hold(record: Record, late: Mapping[int, float]) -> Record:
    """Return a record whose inputs are held, given as what acts; those known as held stay.

    Parameters
    ----------
    record : Record
        Inputs as the values that begin at the samples.
    late : mapping of int to float
        Which inputs are held, and by how much each is late, in sampling times.

    Returns
    -------
    Record
        The same motion.
    """
    new = {column: share for column, share in late.items() if column not in record.held}
    if record.u is None or not new:
        return record

    def as_acting(_: Array, u: Array) -> Array:
        acting = u.copy()
        for column, share in new.items():
            acting[:, column] = _later(u[:, column], share)
        return acting

    return replace(record.with_inputs(as_acting), held={**record.held, **new})


def _later(u: Array, share: float) -> Array:
    """Return an input, (n_samples,), some sampling times later, at rest before it was recorded."""
    samples = np.arange(u.size, dtype=float)
    return np.asarray(CubicSpline(samples, u)(np.maximum(samples - share, 0.0)))
