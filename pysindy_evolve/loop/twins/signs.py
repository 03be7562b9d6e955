"""Residuals times slow random signals: as strong and as colored, but independent of the states.

The residual keeps its strength at each time, and its color over the memory of the signal. A slow
wander fits a trend or a square by chance, as white noise never does, but sensor noise hides its
long memory. So the slow part of a residual has a signal and a memory of its own.

References
----------
Shao, JASA 105 (2010), DOI 10.1198/jasa.2009.tm08744, the dependent wild bootstrap.
Granger and Newbold, J. Econometrics 2 (1974), DOI 10.1016/0304-4076(74)90034-7: spurious
regressions on series that wander.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import fft
from scipy.ndimage import fourier_gaussian

from ...checks import TINY

# Longest memories of the slow part and of the rest, as shares of a record. What changes faster than
# the longer one is not slow, and the signal of the slow part must still change its sign.
LONGEST, LONGEST_OF_REST = 1.0 / 8.0, 1.0 / 40.0


@dataclass(frozen=True, eq=False)
class Shuffle:
    """Columns split into parts, each with the memory of its random signal.

    Attributes
    ----------
    parts : tuple of ndarray of shape (n_samples, n_columns)
        The slow part, and the rest; their sum is the columns.
    memories : tuple of float
        Of each part: width (standard deviation) of the Gaussian that smooths its signal, samples.
    """

    parts: tuple[np.ndarray, ...]
    memories: tuple[float, ...]

    @classmethod
    def of(cls, columns: np.ndarray) -> Shuffle:
        """Split columns of shape (n_samples, n_columns)."""
        n = len(columns)
        slow = _smoothed(columns, n * LONGEST)
        parts = (slow, columns - slow)
        longest = (n * LONGEST, n * LONGEST_OF_REST)
        return cls(parts, tuple(map(_memory_of, parts, longest)))

    def draw(self, rng: np.random.Generator) -> np.ndarray:
        """Return the parts times new random signals, the same for all columns, and added up."""
        pairs = zip(self.parts, self.memories, strict=True)
        return np.sum([part * _signal(len(part), memory, rng) for part, memory in pairs], axis=0)


def _smoothed(columns: np.ndarray, width: float) -> np.ndarray:
    """Return columns smoothed by a Gaussian of a width in samples, mirrored at the ends.

    By a cosine transform: `scipy.ndimage.gaussian_filter1d` would sum over nearly all rows.
    """
    frequencies = np.pi * np.arange(len(columns))[:, None] / len(columns)
    waves = fft.dct(columns, axis=0) * np.exp(-0.5 * (width * frequencies) ** 2)
    return np.asarray(fft.idct(waves, axis=0))


def _signal(n: int, memory: float, rng: np.random.Generator) -> np.ndarray:
    slow = fft.irfft(fourier_gaussian(fft.rfft(rng.standard_normal(n)), memory, n), n)
    return np.asarray(slow / max(float(np.sqrt(np.mean(slow**2))), TINY))[:, None]


def _memory_of(columns: np.ndarray, longest: float) -> float:
    """Return twice the lag, in samples, at which the autocorrelation has fallen to a tenth.

    The envelope counts, as the autocorrelation of a ringing residual crosses zero much earlier.
    """
    n = len(columns)
    length = fft.next_fast_len(2 * n, real=True)
    spectrum = fft.rfft(columns - columns.mean(axis=0), length, axis=0)
    # Without its negative frequencies, an autocovariance has its envelope as magnitude.
    covariance = np.abs(fft.ifft(np.abs(spectrum) ** 2, length, axis=0)[:n])
    correlation = np.max(covariance / np.maximum(covariance[0], TINY), axis=1)
    lag = int(np.argmax(correlation < 0.1)) or n
    return float(np.clip(2 * lag, 2, max(2, longest)))
