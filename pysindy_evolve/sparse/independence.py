"""How many independent samples a residual holds, in memory that does not grow with its length."""

from __future__ import annotations

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft

__all__ = ["effective_size"]

DIRECT = 8  # lags taken one by one; for nearly white noise the sum ends among them
BLOCK = 1 << 17  # samples whose correlations are taken at once; lags go up to half of it


def effective_size(residual: np.ndarray) -> float:
    """Count the independent samples in an autocorrelated series.

    Parameters
    ----------
    residual : ndarray of shape (n,)
        In order of time.

    Returns
    -------
    float
        n / (1 + 2 sum of autocorrelations before the first below 2 / sqrt(n)), at least 8; n
        itself for fewer than 16 samples.
    """
    n = len(residual)
    centered = residual - residual.mean()
    power = float(centered @ centered)
    if n < 16 or power <= 0.0:
        return float(n)
    quiet = 2.0 / np.sqrt(n)  # what white noise shows by chance
    total = 0.0
    for lag in range(1, min(DIRECT, n // 2)):
        correlation = float(centered[lag:] @ centered[:-lag]) / power
        if correlation < quiet:
            return max(n / (1.0 + 2.0 * total), 8.0)
        total += correlation
    correlations = _autocorrelation(centered) / power
    below = np.flatnonzero(correlations < quiet)
    until = below[0] if len(below) else len(correlations)
    return max(n / (1.0 + 2.0 * float(correlations[:until].sum())), 8.0)


def _autocorrelation(values: np.ndarray) -> np.ndarray:
    """Sum the products at lags from one to half a block, over blocks of the series."""
    n = min(len(values), BLOCK)
    length = next_fast_len(n + n // 2, real=True)  # padded for lags up to n / 2
    total = np.zeros(n // 2 - 1)
    for start in range(0, len(values), n):
        spectrum = rfft(values[start : start + n], length)
        total += irfft(np.abs(spectrum) ** 2, length)[1 : n // 2]
    return total
