"""Records made by a user whose derivatives were smoothed more than their states.

A derivative from a local polynomial (Savitzky-Golay) is smaller than the slope of its state: its
gain at a frequency f is 1 - b f^2. What is missing looks like a force. So the derivatives of such
records are taken anew from the states, up to the frequency at which the states begin to be smoothed
too. A linear equation holds for the slower part of the motion by itself. Any other equation cannot
be judged if the motion is faster than that.

References
----------
Schafer, IEEE Signal Process. Mag. 28 (2011), DOI 10.1109/MSP.2011.941097: these gains.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy import fft

from ...signals import Record
from ...signals.prepare import prepared
from ...warn import warn
from .design import Design

MIN_MISSED_SHARE = 0.001  # share of a slope; a larger systematic miss shows in the loop
MAX_SHARE_OFF_LAW = 0.5  # share of the miss that 1 - b f^2 may leave; more is not due to smoothing
# Share of a slope missed at the new cutoff; there states are right to a few percent.
MISSED_SHARE_AT_CUTOFF = 0.15
MOTION = 0.99  # share of the power of a derivative in the band of the motion
MIN_SAMPLES = 200  # samples; fewer tell no spectra apart
MAX_FAST_SHARE = 0.1  # share of the slopes that may lie above the new cutoff
MAX_TIME_STEP_SPREAD = 1e-3  # largest spread of the time steps, relative to their mean


def with_own_slopes(
    design: Design, train: list[Record], test: list[Record]
) -> tuple[list[Record], list[Record], bool]:
    """Return records whose derivatives are the slopes of their states, and if they show the motion.

    Parameters
    ----------
    design : Design
        The declared model, which says what is the velocity of what.
    train, test : list of Record
        Records made by `prepare`, or by the user.

    Returns
    -------
    train, test : list of Record
        Unchanged, unless the user made them all and a derivative of a training record is too
        smooth.
    shown : bool
        Whether the motion is slow enough for its remaining part to obey the equations.

    Warns
    -----
    UserWarning
        If derivatives are taken anew.
    """
    order = _states_per_column(design)
    if not order or not all(map(_is_made_by_user, [*train, *test])):
        return train, test, True
    cutoff = min(map(_whole_up_to, train))
    if not np.isfinite(cutoff):
        return train, test, True
    shown = _is_linear(design) or all(
        _fast_share(record, cutoff) <= MAX_FAST_SHARE for record in train
    )
    warn(
        "close_loop(train=..., test=...): the derivatives of the records fall short of the slopes "
        f"of their states, by {MISSED_SHARE_AT_CUTOFF:.0%} at {cutoff:.3g} cycles per unit of t: "
        "they are smoothed too much. They are taken anew from the states, up to there. "
        + ("" if shown else "The motion is faster than that, so no effect is looked for. ")
        + "Give the measurement as it is to prepare(t, y, u)."
    )
    train, test = ([_prepared_anew(r, order, cutoff) for r in records] for records in (train, test))
    return train, test, shown


def _states_per_column(design: Design) -> int:
    """Return how many states `prepare` makes of a measured column; 0 if it orders them otherwise.

    One if no state is the derivative of another, two if each position is followed by its velocity.
    """
    n = len(design.states)
    velocities = [design.derivative_of(s) if design.kinematic(s) else None for s in range(n)]
    if velocities == [None] * n:
        return 1
    return 2 if velocities == [s + 1 if s % 2 == 0 else None for s in range(n)] else 0


def _is_linear(design: Design) -> bool:
    """Tell whether each term is one variable, or a constant."""
    sides = [*design.fixed, *(side for column in design.columns for side in column.parts)]
    return all(term.size <= 1 for side in sides for _, term in side.parts)


def _is_made_by_user(record: Record) -> bool:
    """Tell whether a record was made by the user, is long and even, and all of it moves."""
    steps = np.diff(record.t)
    is_even = bool(np.ptp(steps) <= MAX_TIME_STEP_SPREAD * steps.mean())
    moves = bool(np.all(np.ptp(record.x, axis=0) > 0.0))
    return record.preparation is None and record.n_samples >= MIN_SAMPLES and is_even and moves


def _whole_up_to(record: Record) -> float:
    """Return the frequency up to which states are whole; infinite if no derivative is short."""
    frequency = fft.rfftfreq(record.n_samples, record.dt)
    ends = [
        _short_from(frequency, _spectrum(slope), _spectrum(given))
        for slope, given in zip(_slopes(record).T, record.x_dot.T, strict=True)
    ]
    return min(end if end < 0.5 / record.dt else np.inf for end in ends)


def _short_from(frequency: np.ndarray, slope: np.ndarray, given: np.ndarray) -> float:
    """Return where `MISSED_SHARE_AT_CUTOFF` of a slope is missed; infinite if not by 1 - b f^2."""
    band = _band_of_motion(given)
    missing, bent = (slope - given)[band], (frequency**2 * slope)[band]
    size = float(np.sum(np.abs(bent) ** 2))
    b = float(np.sum((missing * bent.conj()).real)) / size if size > 0.0 else 0.0
    missing_power, rest = (np.sum(np.abs(part) ** 2) for part in (missing, missing - b * bent))
    slope_power = np.sum(np.abs(slope[band]) ** 2)
    if (
        b <= 0.0
        or missing_power <= MIN_MISSED_SHARE**2 * slope_power
        or rest > MAX_SHARE_OFF_LAW**2 * missing_power
    ):
        return np.inf
    return float(np.sqrt(MISSED_SHARE_AT_CUTOFF / b))


def _fast_share(record: Record, cutoff: float) -> float:
    """Return the largest share of a slope above a frequency, within the band of the motion."""
    frequency = fft.rfftfreq(record.n_samples, record.dt)
    shares = []
    for slope, given in zip(_slopes(record).T, record.x_dot.T, strict=True):
        power = np.abs(_spectrum(slope))[_band_of_motion(_spectrum(given))] ** 2
        fast = frequency[: len(power)] > cutoff
        shares.append(float(np.sqrt(np.sum(power[fast]) / np.sum(power))))
    return max(shares)


def _slopes(record: Record) -> np.ndarray:
    return np.asarray(np.gradient(record.x, record.t, axis=0, edge_order=2))


def _band_of_motion(spectrum: np.ndarray) -> np.ndarray:
    """Return the frequencies of the motion, from the spectrum of a smooth derivative."""
    power = np.cumsum(np.abs(spectrum) ** 2)
    return np.flatnonzero(power <= MOTION * power[-1])


def _spectrum(column: np.ndarray) -> np.ndarray:
    return np.asarray(fft.rfft((column - column.mean()) * np.hanning(len(column))))


def _prepared_anew(record: Record, order: int, cutoff: float) -> Record:
    """Return a record prepared from the states of another one."""
    y = record.x[:, ::order]
    made = prepared(record.t, y, record.u, order=order, cutoff=cutoff, limits=None)
    return replace(made, states=record.states, inputs=record.inputs, held=record.held)
