"""Wrapped angles: readings within one turn, which jump while the machine turns on."""

from __future__ import annotations

import numpy as np

from .. import checks
from .spectral import Array

TURNS = {"360": 360.0, "2*np.pi": 2.0 * np.pi}  # period as np.unwrap is given it, and its value
BEYOND = 0.02  # turns that noise may add to the range of the readings
# A jump may differ from a turn by JUMP_ERROR turns, and by what the angle moves in a step: the
# second number times the quantile of the steps given by the first.
JUMP_ERROR = 0.01
USUAL_STEP = (0.95, 3.0)
# The unwrapped readings must be a motion. A square wave as high as a turn leaves a constant; one
# with noise leaves noise, whose steps are as large as its range.
LEAST_MOTION = 0.05  # turns, range of the unwrapped readings
# Largest step, share of that range; largest step beside a jump, in turns; and part of a turn that
# the readings may leave out.
MAX_STEADY_STEP = 0.25
# A longer step is a stride. An angle with strides runs fast, so the steps beside them are long too.
# A staircase, such as a set point, a gear or a coarse count, stands still before and after.
STRIDE = 0.05  # turns
STRIDE_BESIDE = 1.0 / 3.0  # least step beside a stride of a running angle, share of the stride


def refuse_wrapped(y: Array) -> None:
    """Raise an error if a column is an angle that starts again after a whole turn.

    Parameters
    ----------
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
            checks.refuse("prepare", "y", "continuous", got, advice)


def first_wrap(column: Array, turn: float) -> int | None:
    """Return the last sample before an angle starts again, or None if it never does.

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
    Between its jumps an angle runs, in the opposite direction; a staircase stands still. Steps of
    less than a twentieth of a turn that begin again after a whole turn could be either, and count
    as an angle.
    """
    if not 1.0 - MAX_STEADY_STEP <= np.ptp(column) / turn <= 1.0 + BEYOND:
        return None
    unwrapped = np.unwrap(column, period=turn)
    steps, remaining = np.abs(np.diff(column)), np.abs(np.diff(unwrapped))
    jumps = np.flatnonzero(steps > 0.5 * turn)
    motion = float(np.ptp(unwrapped))
    if not len(jumps) or motion < LEAST_MOTION * turn or remaining.max() > MAX_STEADY_STEP * motion:
        return None
    quantile, factor = USUAL_STEP
    # Without the zero steps: a coarse encoder mostly stands still.
    usual = float(np.quantile(remaining[remaining > 0.0], quantile))
    if remaining[jumps].max() > JUMP_ERROR * turn + factor * usual:
        return None
    if _n_stairs(np.diff(unwrapped), turn) >= len(jumps):
        return None
    padded = np.pad(steps, 1)  # a spike jumps back at the next sample
    is_wrap = np.maximum(padded[jumps], padded[jumps + 2]) < MAX_STEADY_STEP * turn
    is_wrap &= _runs_on(column, unwrapped, turn, jumps)
    return int(jumps[is_wrap][0]) if is_wrap.any() else None


def _n_stairs(moved: Array, turn: float) -> int:
    """Return the number of strides without a long step in their direction on each side."""
    padded = np.pad(moved, 1)
    before, after = padded[:-2] * np.sign(moved), padded[2:] * np.sign(moved)
    is_stair = np.minimum(before, after) < STRIDE_BESIDE * np.abs(moved)
    return int(np.count_nonzero(is_stair & (np.abs(moved) > STRIDE * turn)))


def _runs_on(column: Array, unwrapped: Array, turn: float, jumps: np.ndarray) -> np.ndarray:
    """Tell for each jump whether the angle moves in the turn before it and in the turn after it."""
    turns = np.round((unwrapped - column) / turn)
    moves = (np.diff(unwrapped) != 0.0) & (np.diff(turns) == 0.0)
    moving = turns[1:][moves]
    return np.asarray(np.isin(turns[jumps], moving) & np.isin(turns[jumps + 1], moving))
