"""The spectral view of a residual: where effects are ranked and tested.

Both sides of an equation are multiplied by tapered sines and cosines (the weak form with Fourier
test functions), and each frequency is weighted by the inverse of its noise. The residual is then
white, so no row counts twice: generalized least squares.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np
from scipy import fft
from scipy.signal.windows import tukey

from ...checks import TINY
from ...terms import Cache
from ..fitting.linear import solve
from ..fitting.residual import force_on
from ..given.design import Column, Design
from ..given.rows import MAX_TERM_VALUE
from ..given.segments import Segments

TAPER = 0.5  # share of a segment over which the taper falls to zero
N_WEIGHINGS = 3  # rounds, each with weights from the residual of the one before
LEAST_POWER = 1e-8  # of the noise, relative to its peak: below it there is only rounding
# Up to so many frequencies, a product with their waves is faster than a whole transform: up to ten
# times for segments whose length is a prime.
MAX_WAVES = 40


def spectral_grams(part: Segments, design: Design, columns: Sequence[Column]) -> np.ndarray:
    """Return the Gram matrices of each segment in the spectral view.

    Parameters
    ----------
    part : Segments
        Rows to look at.
    design : Design
        Supplies the known parts of the equations.
    columns : sequence of Column
        Columns of the design, then candidates.

    Returns
    -------
    ndarray of shape (n_segments, n_columns + 1, n_columns + 1)
    """
    rows = _spectra(part, design, columns)
    weighed = rows * _weights(rows)[:, None, None]
    n_columns, n_segments = rows.shape[1:3]
    flat = weighed.transpose(2, 1, 0, 3).reshape(n_segments, n_columns, -1)
    parts = np.ascontiguousarray(flat).view(float)
    return np.asarray(parts @ np.swapaxes(parts, 1, 2))


def spectral_weights(part: Segments, design: Design, columns: Sequence[Column]) -> np.ndarray:
    """Return the weight of each frequency in each open equation, (n_open, n_frequencies)."""
    return _weights(_spectra(part, design, columns))


def spectral_rows(part: Segments, columns: np.ndarray) -> np.ndarray:
    """Transform tapered segments.

    Parameters
    ----------
    part : Segments
        Sampling time and cutoff.
    columns : ndarray of shape (n_segments, n, n_columns)
        Anything sampled on the segments.

    Returns
    -------
    ndarray of complex of shape (n_segments, n_frequencies, n_columns)
        Frequencies up to the cutoff. A column with a value that is not finite is all zero.
    """
    return np.moveaxis(_transformed(part, np.moveaxis(columns, -1, 0)), 0, -1)


def _transformed(part: Segments, columns: np.ndarray) -> np.ndarray:
    """Transform tapered segments, (n_columns, n_segments, n) to (..., n_frequencies)."""
    length = columns.shape[-1]
    taper, n_frequencies = _taper(length, part.dt, part.cutoff)
    usable = np.all(np.abs(columns) < MAX_TERM_VALUE, axis=(1, 2))  # False for NaN too
    columns = columns if usable.all() else np.where(usable[:, None, None], columns, 0.0)
    if n_frequencies > MAX_WAVES:
        return np.asarray(fft.rfft(columns * taper, axis=-1)[..., :n_frequencies])
    parts = columns.reshape(-1, length) @ _tapered_waves(length, n_frequencies)
    return parts.view(complex).reshape(*columns.shape[:-1], n_frequencies)


def n_frequencies(part: Segments) -> int:
    """Return how many frequencies of a segment are looked at."""
    return _taper(part.z.shape[1], part.dt, part.cutoff)[1]


@lru_cache(maxsize=16)
def _taper(length: int, dt: float, cutoff: float) -> tuple[np.ndarray, int]:
    """Return the taper of a segment, and how many frequencies are looked at."""
    return tukey(length, TAPER), int(np.sum(fft.rfftfreq(length, dt) <= cutoff))


@lru_cache(maxsize=16)
def _tapered_waves(length: int, n_frequencies: int) -> np.ndarray:
    """Return the waves of a transform, tapered: real and imaginary parts in turn."""
    turns = np.outer(np.arange(length), np.arange(n_frequencies)) % length / length
    waves = np.exp(-2j * np.pi * turns)
    return (tukey(length, TAPER)[:, None] * waves).view(float)


def _spectra(part: Segments, design: Design, columns: Sequence[Column]) -> np.ndarray:
    """Return spectra of columns and target, (n_open, n_columns, n_segments, n_frequencies)."""
    cache: Cache = {}
    spectra = []
    for state in design.open_states:
        force = force_on(part, design, columns, state, cache)
        weight = part.weight[:, :, state] / part.rate_scale[state]
        spectra.append(_transformed(part, force * weight))
    return np.stack(spectra)


def _weights(rows: np.ndarray) -> np.ndarray:
    """Weigh each frequency by the inverse of the noise there, (n_open, n_frequencies).

    The noise is the residual of all columns together, candidates included. The residual of the
    model alone would contain the missing effect, and hide it behind its own power.
    """
    target = np.mean(np.abs(rows[:, -1]) ** 2, axis=1)
    # Where a column fits the target exactly there is no noise, and the weight would be infinite.
    rounding = 1e-24 * target.max(axis=-1, keepdims=True) + 1e-100
    weight = np.ones_like(target)
    for _ in range(N_WEIGHINGS):
        gram = _gram(rows, weight)
        contrast = np.append(solve(gram[:-1, :-1], gram[:-1, -1]), -1.0)
        residual = np.tensordot(rows, contrast, axes=(1, 0))
        power = np.mean(np.abs(residual) ** 2, axis=1)
        weight = 1.0 / np.sqrt(np.maximum(_smooth(power), rounding))
    return weight


def _gram(rows: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Return the Gram matrix of weighed columns, over all equations, segments and frequencies."""
    weighed = np.moveaxis(rows * weight[:, None, None], 1, 0)
    parts = np.ascontiguousarray(weighed).reshape(rows.shape[1], -1).view(float)
    return np.asarray(parts @ parts.T)


def _smooth(power: np.ndarray) -> np.ndarray:
    """Average a power spectrum over neighbors, up to an eighth of each frequency to both sides."""
    n = power.shape[-1]
    index = np.arange(n)
    reach = 1 + index // 8
    sums = np.concatenate([np.zeros((len(power), 1)), np.cumsum(power, axis=-1)], axis=-1)
    low, high = np.maximum(index - reach, 0), np.minimum(index + reach + 1, n)
    flat = (sums[:, high] - sums[:, low]) / (high - low)
    return np.maximum(flat, np.max(flat, axis=-1, keepdims=True) * LEAST_POWER + TINY)
