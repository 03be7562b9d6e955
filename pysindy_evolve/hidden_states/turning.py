r"""The hidden state of a hysteresis along a path, for all kinds of hysteresis.

A hidden state w follows a position x, given in units of the length of the hysteresis. It leads
where its sign is that of the motion; else the motion has turned:

    dw/d|x| = 1 - a w  where it leads,    1 + b |w|  where x has turned,    b > 0,

with w counted positive in the direction of motion. With a positive a it saturates at 1 / a, as a
friction does; with a negative one it grows ever faster, as a stiffening spring does.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.special import exprel


def turning_along(x: np.ndarray, leading: float, turned: float, start: float = 0.0) -> np.ndarray:
    """Return w along a path; exact if the path is straight between samples.

    Parameters
    ----------
    x : ndarray of shape (n_samples,)
        Positions in time order, over the length of the hysteresis, dimensionless.
    leading, turned : float
        a and b, dimensionless.
    start : float
        w on the first row.

    Returns
    -------
    ndarray of shape (n_samples,)
    """
    signs, begins = _directions(x)
    runs = np.abs(np.diff(x[begins]))
    stretches = signs, runs, np.exp(-leading * runs), _grown(runs, leading)
    w, at_turns = start, []
    for sign, run, decay, grown in zip(*(p.tolist() for p in stretches), strict=True):
        at_turns.append(w)
        w_along = sign * w  # positive in the direction of motion
        # The run that is left when w comes to zero; negative if it does not.
        beyond = run - math.log1p(-turned * min(w_along, 0.0)) / turned
        if w_along >= 0.0:
            w_along = w_along * decay + grown
        elif beyond < 0.0:
            w_along = -math.expm1(-turned * beyond) / turned
        else:
            w_along = float(_grown(beyond, leading))
        w = sign * w_along
    # Now all rows at once: the loop over turns is fast, a loop over rows would be slow.
    rows = np.diff(begins)
    first, turns, sign = (
        np.repeat(values, rows) for values in (x[begins[:-1]], np.array(at_turns), signs)
    )
    w_along, run = sign * turns, np.abs(x[1:] - first)
    beyond = run - np.log1p(-turned * np.minimum(w_along, 0.0)) / turned
    before_zero = -np.expm1(-turned * np.minimum(beyond, 0.0)) / turned
    w_turned = np.where(beyond < 0.0, before_zero, _grown(np.maximum(beyond, 0.0), leading))
    w_leading = w_along * np.exp(-leading * run) + _grown(run, leading)
    return np.concatenate([[start], sign * np.where(w_along >= 0.0, w_leading, w_turned)])


def _grown(run: np.ndarray | float, leading: float) -> np.ndarray:
    """Return w after a run that began at w = 0 and leads."""
    return np.asarray(run * exprel(-leading * run))


def _directions(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the sign of each stretch between turns of a path, and the rows where they begin.

    The last row is appended as the end. A rest belongs to the stretch before it.
    """
    signs_of_steps = np.sign(np.diff(x))
    moves = np.flatnonzero(signs_of_steps)
    if not len(moves):
        return np.ones(1 if len(x) > 1 else 0), np.unique([0, len(x) - 1])
    signs = signs_of_steps[moves]
    turns = np.flatnonzero(np.diff(signs)) + 1
    begins = np.concatenate([[0], moves[turns], [len(x) - 1]]).astype(int)
    return signs[np.concatenate([[0], turns])], begins
