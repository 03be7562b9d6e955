"""Where a body moves: rows on which its velocity is more than noise.

At rest the friction is whatever balances the other forces, and the sign of a noisy velocity is a
coin toss. Such rows say nothing about an equation with sgn(v) in it, so they carry no weight; the
weights multiply target and terms alike, before anything else.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...signals import Record

__all__ = ["moving", "noise_of"]

AT_REST = 4.0  # standard deviations of the velocity noise below which a row has no weight ...
IN_MOTION = 8.0  # ... and above which it has all
LEAST = 1e-3  # share of the RMS velocity that is rest, however little noise there is
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
        if share.mean() >= ENOUGH:
            weights[:, state] = share * share * (3.0 - 2.0 * share)
    if record.seen is not None:  # each equation may hold every state
        weights *= np.all(record.seen, axis=1)[:, None]
    return weights


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
