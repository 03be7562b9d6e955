"""Where a body moves: rows on which its velocity is more than noise.

At rest the friction is whatever balances the other forces, and the sign of a noisy velocity is a
coin toss. Such rows say nothing about an equation with sgn(v) in it, so they carry no weight; the
weights multiply target and terms alike, before anything else.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy import ndimage

from ...signals import Record

__all__ = ["moving", "noise_of"]

AT_REST = 4.0  # standard deviations of the velocity noise below which a row has no weight ...
IN_MOTION = 8.0  # ... and above which it has all
LEAST = 1e-3  # share of the RMS velocity that is rest, however little noise there is
STUCK = 1.0  # periods of the cutoff that a rest lasts at least
STILL = 0.1  # share of the RMS acceleration below which a quarter of the rows of a rest lie
OFTEN = 3  # rests of a record between motions, from which on it sticks again and again
MIXED, FORGOTTEN = 0.75, 1.5  # periods of it next to a rest, in which the low-pass mixes it in
ENOUGH = 0.2  # share of the weight that must be left; a body that hardly moves is looked at whole


def moving(record: Record, velocities: Sequence[int]) -> np.ndarray:
    """Return the weight of each row in the equation of each state.

    Parameters
    ----------
    record : Record
        What was measured.
    velocities : sequence of int
        States that are velocities; the others have weight one everywhere.

    Returns
    -------
    ndarray of shape (n_samples, n_states)
        Between 0 (at rest) and 1 (in motion); 0 where a sensor was at an end of its range.
    """
    weights = np.ones_like(record.x)
    for state in velocities:
        speed = np.abs(record.x[:, state])
        noise = noise_of(record, state)
        low = max(AT_REST * noise, LEAST * float(np.sqrt(np.mean(speed**2))))
        high = low * IN_MOTION / AT_REST
        share = np.clip((speed - low) / max(high - low, 1e-300), 0.0, 1.0)
        apart = share * _away_from_rest(record, state, speed < low)
        share = apart if apart.mean() >= ENOUGH else share
        if share.mean() >= ENOUGH:
            weights[:, state] = share * share * (3.0 - 2.0 * share)
    if record.seen is not None:  # each equation may hold every state
        weights *= np.all(record.seen, axis=1)[:, None]
    return weights


def _away_from_rest(record: Record, state: int, slow: np.ndarray) -> np.ndarray:
    """Return 0 next to where a body sticks, rising to 1 where the low-pass has forgotten that.

    The low-pass mixes what is at rest with the motion next to it. That matters to a body that
    sticks again and again, not to one that comes to rest once, at the end of its record.
    """
    made = record.preparation
    if made is None or made.cutoff is None:
        return np.ones(len(slow))
    period = 1.0 / (made.cutoff * record.dt)
    long = ndimage.binary_opening(slow, np.ones(max(round(STUCK * period), 2), dtype=bool))
    stuck = _still(np.abs(record.x_dot[:, state]), long)
    if not stuck.any():
        return np.ones(len(slow))
    distance = ndimage.distance_transform_edt(~stuck) / period
    return np.asarray(np.clip((distance - MIXED) / (FORGOTTEN - MIXED), 0.0, 1.0))


def _still(acceleration: np.ndarray, slow: np.ndarray) -> np.ndarray:
    """Tell on which rows a body rests between motions, if it does often.

    At a turning point it is slow too, but accelerates.
    """
    still = STILL * float(np.sqrt(np.mean(acceleration**2)))
    spans, n_spans = ndimage.label(slow)
    ends = {int(spans[0]), int(spans[-1])}
    rests = [
        span
        for span in range(1, n_spans + 1)
        if span not in ends and np.quantile(acceleration[spans == span], 0.25) < still
    ]
    return np.isin(spans, rests if len(rests) >= OFTEN else [])


def noise_of(record: Record, state: int, further: int = 0) -> float:
    """Return the standard deviation of the noise in a state, or in its further derivatives.

    White noise of density 2 dt s^2 that is derived k times has (2 pi f)^(2 k) times that density,
    up to the cutoff.
    """
    made = record.preparation
    if made is None or state // made.order >= len(made.noise):
        return 0.0
    order = state % made.order + further
    top = made.cutoff or 0.5 / made.dt
    power = (2 * np.pi) ** (2 * order) * top ** (2 * order + 1) / (2 * order + 1)
    return float(made.noise[state // made.order] * np.sqrt(2.0 * made.dt * power))
