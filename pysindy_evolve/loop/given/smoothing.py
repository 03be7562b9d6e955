"""Records made by a user whose derivatives were smoothed more than their states.

A derivative from a local polynomial (Savitzky and Golay) falls short of the slope of the state that
it is the derivative of, the more the faster the motion: its gain is 1 - b f^2 at a frequency f, and
what is missing looks like a force. So the derivatives of such a record are taken anew from its
states, up to the frequency at which the states themselves begin to be smoothed. A linear equation
holds for what is slower by itself; of the others nothing can be told where the motion is faster.

References
----------
Schafer, IEEE Signal Process. Mag. 28 (2011), DOI 10.1109/MSP.2011.941097: these gains.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy import fft

from ...signals import Record, prepare
from ...warn import warn
from .design import Design

__all__ = ["with_own_slopes"]

MISSED = 0.001  # of a slope: what is regular and no noise shows in the loop from there
LAW = 0.5  # of what is missed, that may be left by 1 - b f^2: more is no smoothing
LOST = 0.15  # of a slope, at the frequency up to which the states are whole within a few percent
MOTION = 0.99  # of the power of a derivative lies below the frequencies that are looked at
FEWEST = 200  # samples; fewer tell no spectra apart
FAST = 0.1  # of the slopes, that may lie above that frequency
EVEN = 1e-3  # sampling times by which samples may be off


def with_own_slopes(
    design: Design, train: list[Record], test: list[Record]
) -> tuple[list[Record], list[Record], bool]:
    """Return records whose derivatives are the slopes of their states, and if they show the motion.

    Parameters
    ----------
    design : Design
        The declared model, which says what is the velocity of what.
    train, test : list of Record
        Made by `prepare`, or by the user.

    Returns
    -------
    train, test : list of Record
        All as they are, unless all are made by the user and a derivative of a training record at
        least is too smooth.
    shown : bool
        Whether the motion is slow enough for what is left of it to obey the equations.

    Warns
    -----
    UserWarning
        If derivatives are taken anew.
    """
    order = _states_each(design)
    if not order or not all(map(_is_own, [*train, *test])):
        return train, test, True
    cutoff = min(map(_whole_up_to, train))
    if not np.isfinite(cutoff):
        return train, test, True
    shown = _is_linear(design) or all(_fast_share(record, cutoff) <= FAST for record in train)
    warn(
        "close_loop(train=..., test=...): the derivatives of the records fall short of the slopes "
        f"of their states, by {LOST:.0%} at {cutoff:.3g} cycles per unit of t: they are smoothed "
        "too much. They are taken anew from the states, up to there. "
        + ("" if shown else "The motion is faster than that, so no effect is looked for. ")
        + "Give the measurement as it is to prepare(t, y, u).",
    )
    train, test = ([_anew(r, order, cutoff) for r in records] for records in (train, test))
    return train, test, shown


def _states_each(design: Design) -> int:
    """Return how many states each measured one makes, as `prepare` orders them; 0 if it would not.

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


def _is_own(record: Record) -> bool:
    """Tell whether a record was made by the user, is long and even, and all of it moves."""
    steps = np.diff(record.t)
    is_even = bool(np.ptp(steps) <= EVEN * steps.mean())
    moves = bool(np.all(np.ptp(record.x, axis=0) > 0.0))
    return record.preparation is None and record.n_samples >= FEWEST and is_even and moves


def _whole_up_to(record: Record) -> float:
    """Return the frequency up to which the states are whole; infinite if no derivative is short."""
    frequency = fft.rfftfreq(record.n_samples, record.dt)
    ends = [
        _short_from(frequency, _spectrum(slope), _spectrum(given))
        for slope, given in zip(_slopes(record).T, record.x_dot.T, strict=True)
    ]
    return min(end if end < 0.5 / record.dt else np.inf for end in ends)


def _short_from(frequency: np.ndarray, slope: np.ndarray, given: np.ndarray) -> float:
    """Return where a derivative falls short; infinite if it does not, or not by 1 - b f^2."""
    moves = _moves(given)
    short, bent = (slope - given)[moves], (frequency**2 * slope)[moves]
    size = float(np.sum(np.abs(bent) ** 2))
    b = float(np.sum((short * bent.conj()).real)) / size if size > 0.0 else 0.0
    missed, left = (np.sum(np.abs(part) ** 2) for part in (short, short - b * bent))
    whole = np.sum(np.abs(slope[moves]) ** 2)
    if b <= 0.0 or missed <= MISSED**2 * whole or left > LAW**2 * missed:
        return np.inf
    return float(np.sqrt(LOST / b))


def _fast_share(record: Record, cutoff: float) -> float:
    """Return how much of the slopes lies above a frequency, at most, of the motion seen at all."""
    frequency = fft.rfftfreq(record.n_samples, record.dt)
    shares = []
    for slope, given in zip(_slopes(record).T, record.x_dot.T, strict=True):
        power = np.abs(_spectrum(slope))[_moves(_spectrum(given))] ** 2
        fast = frequency[: len(power)] > cutoff
        shares.append(float(np.sqrt(np.sum(power[fast]) / np.sum(power))))
    return max(shares)


def _slopes(record: Record) -> np.ndarray:
    return np.asarray(np.gradient(record.x, record.t, axis=0, edge_order=2))


def _moves(spectrum: np.ndarray) -> np.ndarray:
    """Return the frequencies of the motion, from the spectrum of a smooth derivative."""
    power = np.cumsum(np.abs(spectrum) ** 2)
    return np.flatnonzero(power <= MOTION * power[-1])


def _spectrum(column: np.ndarray) -> np.ndarray:
    return np.asarray(fft.rfft((column - column.mean()) * np.hanning(len(column))))


def _anew(record: Record, order: int, cutoff: float) -> Record:
    """Return a record prepared from the states of another one."""
    y = record.x[:, ::order]
    made = prepare(record.t, y, record.u, order=order, cutoff=cutoff, limits=None)
    return replace(made, states=record.states, inputs=record.inputs, held=record.held)
