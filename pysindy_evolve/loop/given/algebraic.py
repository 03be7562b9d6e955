"""Algebraic targets: the model gives a quantity itself, such as a force, and not its rate.

The effects of the vocabulary are functions of inputs here: of a position and its velocity if two
inputs are such a pair, of any other input by itself.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...signals import Record

# Correlation from which on an input counts as the slope of another one.
MIN_SLOPE_CORRELATION = 0.98


def as_algebraic(record: Record) -> Record:
    """Return a record whose targets, its columns of x, take the place of the rates."""
    return replace(record, x_dot=record.x, preparation=None)


def motions_of(records: Sequence[Record], n_states: int) -> tuple[tuple[int, int], ...]:
    """Return which inputs are position and velocity of the same motion, as variables.

    Parameters
    ----------
    records : sequence of Record
        Training records.
    n_states : int
        Inputs are numbered after so many states.

    Returns
    -------
    tuple of (int, int)
        Position and velocity.
    """
    first = records[0]
    n = first.n_inputs
    found = []
    for position in range(n):
        for velocity in (k for k in range(n) if k != position):
            pairs = [
                (np.gradient(r.u[:, position], r.t), r.u[:, velocity])
                for r in records
                if r.u is not None
            ]
            slope, given = (np.concatenate(side) for side in zip(*pairs, strict=True))
            if slope.std() > 0.0 and given.std() > 0.0:
                is_slope = np.corrcoef(slope, given)[0, 1] > MIN_SLOPE_CORRELATION
                if is_slope and np.isclose(slope.std(), given.std(), rtol=0.2):
                    found.append((n_states + position, n_states + velocity))
    return tuple(found)
