"""What a record does not know of its inputs: the noise of their sensors, and the time in between.

An input that jumps between levels is held from one sample to the next. It is recorded at best as
the mean of the values before and after each sample. What follows from it is a little larger, by the
share (omega dt)^2 / 12 at the frequency omega; a state that it drives directly seems so by twice as
much, as its samples do not tell straight pieces from a curve. That can be made up for. Where the
value itself is recorded that begins at a sample, the motion is late by half a sample besides, see
signals/zero_order_hold.py. An input that runs smoothly is known between its samples as well.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.ndimage import label

from ...signals import Record
from ...signals.noise import input_noise

__all__ = [
    "as_held",
    "input_error",
    "is_held",
    "jumps_at_once",
    "known_up_to",
    "may_be_held",
    "may_be_steps",
    "untimely",
]

STILL = 0.2  # share of the steps from sample to sample that are small, if an input is held ...
SMALL = 0.1  # ... in sizes of all its steps: of a sine that runs on a fifth are below 0.4
LARGE = 0.25  # of the largest step: these are its jumps
QUICKER = 1.0 / 6.0  # of the second difference, for a state that is driven directly
TYPICAL = 1.0 / np.sqrt(12.0)  # samples by which a jump at any time between two is off, rms
FORETOLD = 0.25  # correlation of a step with the next; that of a mean of steps is a half
DOUBT = 0.05  # of a held input: more of it is not known at the frequencies that are looked at


def as_held(record: Record) -> Record:
    """Return a record whose held inputs, recorded as means about the samples, act as they did."""
    if not record.has_raw_inputs:
        return record
    means = _samples_of_jumps(record.raw_u) == 2
    means[list(record.held)] = False  # which are given as what acts
    if not means.any():
        return record
    direct = record.preparation is not None and record.preparation.order == 1
    share = QUICKER if direct else 0.5 * QUICKER
    return record.with_inputs(lambda _, u: u - np.where(means, share * _bend(u), 0.0))


def is_held(record: Record, column: int) -> bool:
    """Tell whether an input was held between the jumps that its raw samples show."""
    known = column in record.held
    return record.has_raw_inputs and (known or _samples_of_jump(record.raw_u[:, column]) > 0)


def jumps_at_once(record: Record, column: int) -> bool:
    """Tell whether an input jumps in one step, somewhere between two samples."""
    return record.has_raw_inputs and _samples_of_jump(record.raw_u[:, column]) == 1


def may_be_held(record: Record, column: int) -> bool:
    """Tell whether an input may be held from each sample to the next, by the looks of its steps.

    It jumps at once, or moves with every sample as if at random, as the output of a controller does
    that answers the noise of its sensor.
    """
    return record.has_raw_inputs and may_be_steps(record.raw_u[:, column])


def may_be_steps(u: np.ndarray) -> bool:
    """Tell the same of the raw samples of an input, (n_raw,)."""
    steps = np.diff(u)
    is_random = steps[1:] @ steps[:-1] < FORETOLD * (steps @ steps)
    return _samples_of_jump(u) == 1 or bool(is_random)


def known_up_to(record: Record) -> float:
    """Return the frequency up to which inputs are known well, cycles per unit of t."""
    if not record.has_raw_inputs or not _samples_of_jumps(record.raw_u).any():
        return np.inf
    return float(np.sqrt(DOUBT / QUICKER) / (2.0 * np.pi * record.raw_dt))


def input_error(
    record: Record, rng: np.random.Generator, columns: frozenset[int] | None = None
) -> np.ndarray | None:
    """Draw by what the inputs of a record may differ from those that drove the machine.

    Parameters
    ----------
    record : Record
        Made from raw data, or nothing is known of its inputs.
    rng : numpy.random.Generator
        Draws the noise.
    columns : frozenset of int, optional
        The inputs in question; by default all.

    Returns
    -------
    ndarray of shape (n_samples, n_inputs) or None
        Units of u, after the low-pass of the record. None if there are no inputs, or no raw data.
    """
    if not record.has_raw_inputs:
        return None
    u = record.raw_u
    noise = input_noise(u, record.raw_dt, record.cutoff) * rng.standard_normal(u.shape)
    asked = range(u.shape[1]) if columns is None else columns
    at_work = np.isin(np.arange(u.shape[1]), list(asked))
    return record.lowpass((noise + _between(u)) * at_work)


def untimely(
    record: Record, columns: Sequence[int], rng: np.random.Generator | None = None
) -> np.ndarray | None:
    """Return by what inputs differ from their record that jump at any time between two samples.

    Parameters
    ----------
    record : Record
        Made from raw data, or nothing is known of its inputs.
    columns : sequence of int
        The inputs in question; the others are as recorded.
    rng : numpy.random.Generator, optional
        Draws the time of each jump; by default each is as far off as the draws are on average.

    Returns
    -------
    ndarray of shape (n_samples, n_inputs) or None
        Units of u, after the low-pass of the record. None where no input jumps in one step.
    """
    if not record.has_raw_inputs:
        return None
    jumping = [k for k in columns if _samples_of_jump(record.raw_u[:, k]) == 1]
    if not jumping:
        return None
    steps = np.diff(record.raw_u[:, jumping], axis=0)
    shares = np.full(len(steps), TYPICAL) if rng is None else rng.uniform(-0.5, 0.5, len(steps))
    moved = shares[:, None] * steps  # samples times height: an area
    nothing = np.zeros((1, len(jumping)))
    about = 0.5 * (np.vstack([moved, nothing]) + np.vstack([nothing, moved]))
    error = np.zeros((record.n_samples, record.n_inputs))
    error[:, jumping] = record.lowpass(about)
    return error


def _between(u: np.ndarray) -> np.ndarray:
    """Return by how much held inputs, (n_raw, n_inputs), may differ from their records."""
    jumps = _samples_of_jumps(u)
    late = 0.5 * np.diff(u, axis=0, prepend=u[:1])
    return np.where(jumps > 0, -QUICKER * _bend(u), 0.0) - np.where(jumps == 1, late, 0.0)


def _bend(u: np.ndarray) -> np.ndarray:
    """Return the second differences of columns, of the same shape."""
    return np.diff(u, n=2, axis=0, prepend=u[:1], append=u[-1:])


def _samples_of_jumps(u: np.ndarray) -> np.ndarray:
    """Return how many steps a jump takes: 1, or 2 of a mean; 0 for inputs that are not held."""
    return np.array([_samples_of_jump(column) for column in u.T])


def _samples_of_jump(u: np.ndarray) -> int:
    steps = np.diff(u)
    sizes = np.abs(steps)
    if np.quantile(sizes, STILL) >= SMALL * np.sqrt(np.mean(steps**2)):
        return 0
    least = LARGE * sizes.max()
    lengths = [np.bincount(label(way > least)[0])[1:] for way in (steps, -steps)]
    median = int(np.median(np.concatenate(lengths)))
    return median if median <= 2 else 0
