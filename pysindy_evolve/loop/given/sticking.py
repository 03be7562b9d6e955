"""Where a body moves: rows on which its velocity is more than noise.

At rest the friction is whatever balances the other forces, and the sign of a noisy velocity is
random. Such rows say nothing about an equation with sgn(v) in it, so they carry no weight. The
weights multiply target and terms alike, before anything else.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy import ndimage

from ...checks import TINY
from ...operators import BUILTIN
from ...signals import Record
from ...terms import Call, variable
from .design import Design

AT_REST = 4.0  # standard deviations of the velocity noise below which a row has no weight ...
IN_MOTION = 8.0  # ... and above which it has all
# Share of the RMS velocity that counts as rest, however little noise there is.
REST_SHARE_OF_RMS = 1e-3
STUCK = 1.0  # least length of a rest, in periods of the cutoff
MAX_CREEP_RATIO = 0.3  # largest median speed of a rest, relative to the speed that counts as slow
MIN_RESTS = 3  # rests between motions of a record from which on a body sticks repeatedly
MIXED, FORGOTTEN = 0.75, 1.5  # distance from a rest, in periods, of weight 0 and of weight 1
MIN_MEAN_WEIGHT = 0.2  # least mean weight; a body that moves less has weight one everywhere


def may_rest(design: Design, records: Sequence[Record]) -> tuple[int, ...]:
    """Return the open states that a friction may hold at rest.

    Parameters
    ----------
    design : Design
        Says which states are velocities, and which have a friction in their equation: a speed may
        be a state of the first order.
    records : sequence of Record
        Show which states rest again and again, whatever holds them.

    Returns
    -------
    tuple of int
    """
    if design.algebraic:
        return design.velocities
    return tuple(
        state
        for state in design.open_states
        if state in design.velocities
        or _has_sign(design, state)
        or any(_rests_often(record, state) for record in records)
    )


def _has_sign(design: Design, state: int) -> bool:
    sign = Call(BUILTIN["sgn"], (variable(state),))
    return any(sign in dict(term.factors) for term in design.terms_of(state))


def _rests_often(record: Record, state: int) -> bool:
    return not np.all(_away_from_rest(record, _speed(record, state)) == 1.0)


def weights_in_motion(record: Record, resting: Sequence[int]) -> np.ndarray:
    """Return the weight of each row in the equation of each state.

    Parameters
    ----------
    record : Record
        What was measured.
    resting : sequence of int
        States that may be at rest; the others have weight one everywhere.

    Returns
    -------
    ndarray of shape (n_samples, n_states)
        Between 0 (at rest) and 1 (in motion); 0 where a sensor was at an end of its range.
    """
    weights = np.ones_like(record.x)
    for state in resting:
        speed = _speed(record, state)
        share = np.clip((speed - 1.0) / (IN_MOTION / AT_REST - 1.0), 0.0, 1.0)
        without_rests = share * _away_from_rest(record, speed)
        share = without_rests if without_rests.mean() >= MIN_MEAN_WEIGHT else share
        if share.mean() >= MIN_MEAN_WEIGHT:
            weights[:, state] = share * share * (3.0 - 2.0 * share)
    if record.seen is not None:  # each equation may hold every state
        weights *= np.all(record.seen, axis=1)[:, None]
    return weights


def _speed(record: Record, state: int) -> np.ndarray:
    """Return the magnitude of a state, relative to what counts as slow."""
    speed = np.abs(record.x[:, state])
    rms = float(np.sqrt(np.mean(speed**2)))
    low = max(AT_REST * noise_of(record, state), REST_SHARE_OF_RMS * rms)
    return speed / max(low, TINY)


def _away_from_rest(record: Record, speed: np.ndarray) -> np.ndarray:
    """Return 0 next to rows where a body sticks, rising to 1 beyond the reach of the low-pass.

    The low-pass mixes rows at rest with the motion next to them. That matters if a body sticks
    again and again, not if it comes to rest once, at the end of its record. The speed is relative
    to the speed that counts as slow.
    """
    if record.cutoff is None:
        return np.ones(len(speed))
    period = 1.0 / (record.cutoff * record.dt)
    at_rest = _stuck(speed, max(round(STUCK * period), 2))
    if not at_rest.any():
        return np.ones(len(speed))
    distance = ndimage.distance_transform_edt(~at_rest) / period
    return np.asarray(np.clip((distance - MIXED) / (FORGOTTEN - MIXED), 0.0, 1.0))


def _stuck(speed: np.ndarray, n_rows: int) -> np.ndarray:
    """Tell on which rows a body rests between motions, if it does so often.

    It is slow at turning points and in a decaying swing too, but there it passes evenly through all
    slow speeds.
    """
    spans, n_spans = ndimage.label(ndimage.binary_opening(speed < 1.0, np.ones(n_rows, dtype=bool)))
    typical = ndimage.median(speed, spans, np.arange(1, n_spans + 1))
    rests = set(1 + np.flatnonzero(np.asarray(typical) < MAX_CREEP_RATIO)) - {spans[0], spans[-1]}
    return np.isin(spans, list(rests) if len(rests) >= MIN_RESTS else [])


def noise_of(record: Record, state: int, further: int = 0) -> float:
    """Return the standard deviation of the noise in a state, or in its further derivatives.

    White noise of density 2 dt s^2, differentiated k times, has (2 pi f)^(2 k) times that density,
    up to the cutoff.
    """
    made = record.preparation
    if made is None or state // made.order >= len(made.noise):
        return 0.0
    order = state % made.order + further
    top = made.cutoff or 0.5 / made.dt
    power = (2 * np.pi) ** (2 * order) * top ** (2 * order + 1) / (2 * order + 1)
    return float(made.noise[state // made.order] * np.sqrt(2.0 * made.dt * power))
