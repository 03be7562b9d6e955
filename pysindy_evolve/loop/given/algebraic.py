"""Algebraic targets: the model gives a quantity itself, such as a force, and not its rate.

The effects of the vocabulary are functions of inputs here: of a position and its velocity if two
inputs are such a pair, of any other input by itself.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import permutations

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
    return tuple(
        (n_states + position, n_states + velocity)
        for position, velocity in permutations(range(records[0].n_inputs), 2)
        if _is_slope(velocity, position, records)
    )


def _is_slope(velocity: int, position: int, records: Sequence[Record]) -> bool:
    """Tell whether one input is the derivative of another."""
    pairs = [
        (np.gradient(r.u[:, position], r.t), r.u[:, velocity]) for r in records if r.u is not None
    ]
    slope, given = (np.concatenate(side) for side in zip(*pairs, strict=True))
    if slope.std() == 0.0 or given.std() == 0.0:
        return False
    is_alike = np.corrcoef(slope, given)[0, 1] > MIN_SLOPE_CORRELATION
    return bool(is_alike and np.isclose(slope.std(), given.std(), rtol=0.2))
