"""Errors of recorded inputs: the noise of their sensors, and changes between samples.

An input that jumps between levels is held from one sample to the next. At best it is recorded as
the mean of the values before and after each sample. The true response is larger, by the share
(omega dt)^2 / 12 at the frequency omega. A state that is driven directly seems larger by twice as
much, since its samples do not distinguish straight pieces from a curve. Both can be corrected. If
the value that begins at a sample is recorded, the motion is also late by half a sample, see
signals/zero_order_hold.py. A smooth input is known between its samples as well.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.ndimage import label

from ...signals import Record
from ...signals.noise import input_noise

# An input is held if this share of its steps from sample to sample is small ...
STILL_STEP_SHARE = 0.2
MAX_STILL_STEP = 0.1  # ... relative to their RMS; of a steady sine, a fifth is below 0.4
MIN_JUMP_SHARE = 0.25  # a jump is a step above this share of the largest one
QUICKER = 1.0 / 6.0  # factor of the second difference that corrects a directly driven state
TYPICAL = 1.0 / np.sqrt(12.0)  # RMS error, in samples, of a jump at any time between two
FORETOLD = 0.25  # correlation of successive steps below which they are random; means have 0.5
MAX_UNKNOWN_SHARE = 0.05  # largest unknown share of a held input at the frequencies of the search


def as_held(record: Record) -> Record:
    """Return a record with corrected inputs, where they were held but recorded as means."""
    if not record.has_raw_inputs:
        return record
    means = _samples_of_jumps(record.raw_u) == 2
    means[list(record.held)] = False  # already given as they act
    if not means.any():
        return record
    direct = record.preparation is not None and record.preparation.order == 1
    share = QUICKER if direct else 0.5 * QUICKER
    return record.with_inputs(lambda _, u: u - np.where(means, share * _bend(u), 0.0))


def is_held(record: Record, column: int) -> bool:
    """Tell whether an input was held between the jumps that its raw samples show."""
    is_known = column in record.held
    return record.has_raw_inputs and (is_known or _samples_of_jump(record.raw_u[:, column]) > 0)


def jumps_at_once(record: Record, column: int) -> bool:
    """Tell whether an input jumps in one step, somewhere between two samples."""
    return record.has_raw_inputs and _samples_of_jump(record.raw_u[:, column]) == 1


def may_be_held(record: Record, column: int) -> bool:
    """Tell whether an input may be held from each sample to the next, judging by its steps.

    It jumps at once, or moves at random with every sample, as the output of a controller does that
    reacts to sensor noise.
    """
    return record.has_raw_inputs and may_be_steps(record.raw_u[:, column])


def may_be_steps(u: np.ndarray) -> bool:
    """Tell the same from the raw samples of an input, (n_raw,)."""
    steps = np.diff(u)
    is_random = steps[1:] @ steps[:-1] < FORETOLD * (steps @ steps)
    return _samples_of_jump(u) == 1 or bool(is_random)


def known_up_to(record: Record) -> float:
    """Return the frequency up to which inputs are known well, cycles per unit of t."""
    if not record.has_raw_inputs or not _samples_of_jumps(record.raw_u).any():
        return np.inf
    return float(np.sqrt(MAX_UNKNOWN_SHARE / QUICKER) / (2.0 * np.pi * record.raw_dt))


def input_error(
    record: Record, rng: np.random.Generator, columns: frozenset[int] | None = None
) -> np.ndarray | None:
    """Draw the error of recorded inputs: noise, and what they did between samples.

    Parameters
    ----------
    record : Record
        Made from raw data; otherwise nothing is known about its inputs.
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
    is_asked = np.isin(np.arange(u.shape[1]), list(asked))
    return record.lowpass((noise + _between(u)) * is_asked)


def jump_time_error(
    record: Record, columns: Sequence[int], rng: np.random.Generator | None = None
) -> np.ndarray | None:
    """Return the error of recorded inputs that jump at any time between two samples.

    Parameters
    ----------
    record : Record
        Made from raw data; otherwise nothing is known about its inputs.
    columns : sequence of int
        The inputs in question; the others are as recorded.
    rng : numpy.random.Generator, optional
        Draws the time of each jump; by default each is off by the RMS of such draws.

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
    zero = np.zeros((1, len(jumping)))
    spread = 0.5 * (np.vstack([moved, zero]) + np.vstack([zero, moved]))
    error = np.zeros((record.n_samples, record.n_inputs))
    error[:, jumping] = record.lowpass(spread)
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
    if np.quantile(sizes, STILL_STEP_SHARE) >= MAX_STILL_STEP * np.sqrt(np.mean(steps**2)):
        return 0
    least = MIN_JUMP_SHARE * sizes.max()
    lengths = [np.bincount(label(signed > least)[0])[1:] for signed in (steps, -steps)]
    median = int(np.median(np.concatenate(lengths)))
    return median if median <= 2 else 0
