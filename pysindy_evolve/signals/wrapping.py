"""Angles that a sensor shows within one turn: they jump where the machine goes on."""

from __future__ import annotations

import numpy as np

from .. import checks
from .spectral import Array

TURNS = {"360": 360.0, "2*np.pi": 2.0 * np.pi}  # as they are written, and their size
BEYOND = 0.02  # share of a turn that noise may add to the range of readings
CLOSE = 0.01  # share of a turn that a jump may miss it by, beside what the angle moves meanwhile
USUAL = (0.95, 3.0)  # quantile of the steps that is usual, and how many of them a jump may miss
# What is left without the jumps must be a motion: a square wave as high as a turn leaves nothing,
# and one with noise leaves noise, whose steps are as large as its range.
LEAST_MOTION = 0.05  # turns
STEADY = 0.25  # largest step, share of the range; and largest step beside a jump, in turns
# A longer step is a stride. An angle that takes them runs fast, and so do the steps beside them; a
# staircase, such as a set point, a gear or a coarse count, stands before and after.
STRIDE = 0.05  # turns
BESIDE = 1.0 / 3.0  # least step beside a stride of something that runs, share of the stride


def refuse_wrapped(call: str, y: Array) -> None:
    """Raise where a column is an angle that starts again after a whole turn.

    Parameters
    ----------
    call : str
        Function that was called.
    y : ndarray of shape (n_samples, n_columns)
        Readings, uniformly sampled.

    Raises
    ------
    ValueError
        If a column jumps by a whole turn.
    """
    for index, column in enumerate(y.T):
        for written, turn in TURNS.items():
            at = first_wrap(column, turn)
            if at is None:
                continue
            got = (
                f"a jump from {column[at]:g} to {column[at + 1]:g} at sample {at + 1} of column "
                f"{index}, a whole turn"
            )
            advice = (
                f"Unwrap the angle first: np.unwrap(column, period={written}), on the command "
                f"line --unwrap NAME={turn:.10g}."
            )
            checks.refuse(call, "y", "continuous", got, advice)


def first_wrap(column: Array, turn: float) -> int | None:
    """Return the last sample before an angle starts again, or None where none does.

    Parameters
    ----------
    column : ndarray of shape (n_samples,)
        Readings.
    turn : float
        A whole turn, units of the readings.

    Returns
    -------
    int or None

    Notes
    -----
    An angle runs between its jumps, against them; a staircase stands. Counts of less than a
    twentieth of a turn, up to one whole turn and from zero again, could be either: an angle, then.
    """
    if not 1.0 - STEADY <= np.ptp(column) / turn <= 1.0 + BEYOND:
        return None
    unwrapped = np.unwrap(column, period=turn)
    steps, left = np.abs(np.diff(column)), np.abs(np.diff(unwrapped))
    jumps = np.flatnonzero(steps > 0.5 * turn)
    motion = float(np.ptp(unwrapped))
    if not len(jumps) or motion < LEAST_MOTION * turn or left.max() > STEADY * motion:
        return None
    quantile, times = USUAL
    moved = float(np.quantile(left[left > 0.0], quantile))  # a coarse encoder mostly stands still
    if left[jumps].max() > CLOSE * turn + times * moved:
        return None
    if _n_stairs(np.diff(unwrapped), turn) >= len(jumps):
        return None
    beside = np.pad(steps, 1)  # a spike goes back at the next sample
    clean = np.maximum(beside[jumps], beside[jumps + 2]) < STEADY * turn
    clean &= _runs_on(column, unwrapped, turn, jumps)
    return int(jumps[clean][0]) if clean.any() else None


def _n_stairs(moved: Array, turn: float) -> int:
    """Return how many strides have no steps in their direction on both sides of them."""
    beside = np.pad(moved, 1)
    before, after = beside[:-2] * np.sign(moved), beside[2:] * np.sign(moved)
    alone = np.minimum(before, after) < BESIDE * np.abs(moved)
    return int(np.count_nonzero(alone & (np.abs(moved) > STRIDE * turn)))


def _runs_on(column: Array, unwrapped: Array, turn: float, jumps: np.ndarray) -> np.ndarray:
    """Tell for each jump whether the angle moves in the turn before it and in the one after."""
    turns = np.round((unwrapped - column) / turn)
    moves = (np.diff(unwrapped) != 0.0) & (np.diff(turns) == 0.0)
    moving = turns[1:][moves]
    return np.asarray(np.isin(turns[jumps], moving) & np.isin(turns[jumps + 1], moving))
