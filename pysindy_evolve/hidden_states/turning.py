r"""What remembers which way a path went, along the path: for each kind of hysteresis.

A hidden state w follows a position x, measured in a length of its own. Where w points the way that
x goes it leads, else the motion has turned:

    dw/d|x| = 1 - a w  where it leads,    1 + b |w|  where x has turned,    b > 0,

w being positive in the direction of x. A positive a lets w run to 1 / a, as a friction does; a
negative one lets it grow ever faster, as a spring that stiffens does.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.special import exprel

__all__ = ["turning_along"]


def turning_along(x: np.ndarray, leading: float, turned: float, start: float = 0.0) -> np.ndarray:
    """Return w along a path that is straight between samples, for which it is exact.

    Parameters
    ----------
    x : ndarray of shape (n_samples,)
        Positions in time order, in the length of the hysteresis.
    leading, turned : float
        a and b, dimensionless.
    start : float
        w where the path begins.

    Returns
    -------
    ndarray of shape (n_samples,)
    """
    ups, begins = _directions(x)
    runs = np.abs(np.diff(x[begins]))
    each = ups, runs, np.exp(-leading * runs), _grown(runs, leading)
    w, at_turns = start, []
    for up, run, fades, grows in zip(*(values.tolist() for values in each), strict=True):
        at_turns.append(w)
        along = up * w  # seen along the motion
        after = run - math.log1p(-turned * min(along, 0.0)) / turned  # where w comes to zero
        if along >= 0.0:
            along = along * fades + grows
        elif after < 0.0:
            along = -math.expm1(-turned * after) / turned
        else:
            along = float(_grown(after, leading))
        w = up * along
    # The same on all rows between two turns: numpy is slow on one row, and a loop on many.
    rows = np.diff(begins)
    first, turns, up = (np.repeat(p, rows) for p in (x[begins[:-1]], np.array(at_turns), ups))
    along, run = up * turns, np.abs(x[1:] - first)
    after = run - np.log1p(-turned * np.minimum(along, 0.0)) / turned
    held = -np.expm1(-turned * np.minimum(after, 0.0)) / turned
    turning = np.where(after < 0.0, held, _grown(np.maximum(after, 0.0), leading))
    led = along * np.exp(-leading * run) + _grown(run, leading)
    return np.concatenate([[start], up * np.where(along >= 0.0, led, turning)])


def _grown(run: np.ndarray | float, leading: float) -> np.ndarray:
    """Return w after a run from zero."""
    return np.asarray(run * exprel(-leading * run))


def _directions(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the signs of the stretches in which a path goes one way, and where they begin.

    The last row ends them. A rest belongs to what came before it.
    """
    ups = np.sign(np.diff(x))
    moves = np.flatnonzero(ups)
    if not len(moves):
        return np.ones(1 if len(x) > 1 else 0), np.unique([0, len(x) - 1])
    signs = ups[moves]
    turns = np.flatnonzero(np.diff(signs)) + 1
    begins = np.concatenate([[0], moves[turns], [len(x) - 1]]).astype(int)
    return signs[np.concatenate([[0], turns])], begins
