"""The noise floor of a sensor, and the cutoff that follows from it."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy import fft
from scipy.stats import norm

from .. import checks
from .spectral import Array, Extension, gain

# Highest automatic cutoff, as a share of the sampling rate: the edge of the low-pass, which is
# over at 1.5 times the cutoff, then just ends at the Nyquist frequency.
MAX_SAMPLING_RATE_SHARE = 1.0 / 3.0
# kappa, cost of a unit of noise in units of signal. A lost signal is lost on both sides of an
# equation alike and biases no linear term. Noise that is kept is in the regressors and biases all.
# Ten is also the margin by which a spectrum stands out of its own scatter.
NOISE_PRICE = 10.0
# Standard errors of a median: largest distance of the highest of eight from the lowest, by chance.
MAX_DISTANCE_IN_ERRORS = 4.0
# Candidates for a cutoff, spaced evenly on a logarithmic scale.
N_CANDIDATES = 200
# Least share of readings equal to the one before that makes a column coarse.
DWELL = 0.1
# Share of the steps of an input, the smallest ones, that are taken as noise alone.
NOISE_STEP_SHARE = 0.2
# Fewest periods of the cutoff in a record.
FEWEST_PERIODS = 4.0
# Median of a chi-square variable with two degrees of freedom over its mean.
MEDIAN_OVER_MEAN = np.log(2.0)


def spectrum(y: Array, dt: float, cutoff: float | None = None) -> tuple[Array, Array]:
    """Return frequencies and power of the columns, scaled so that white noise gives its variance.

    Without a cutoff the record is faded in and out (Hann). With one it is extended beyond its ends
    as the filter with that cutoff does, and every sample has the same weight.
    """
    n = y.shape[0]
    if cutoff is None:
        chord = y[0] + np.linspace(0.0, 1.0, n)[:, None] * (y[-1] - y[0])
        window = np.sin(np.pi * (np.arange(n) + 0.5) / n) ** 2
        closed = ((y - chord) * window[:, None]).T
        weight = float(np.sum(window**2))
    else:
        extension = Extension.for_cutoff(n, cutoff, dt)
        total = n + 2 * extension.pad
        closed, _ = extension(y.T, extension.pad, total)
        weight = n + 2.0 * float(np.sum(extension.fade**2))
    total = fft.next_fast_len(closed.shape[1], real=True)
    power = np.abs(fft.rfft(closed, n=total, axis=1)[:, 1:]) ** 2 / weight
    return fft.rfftfreq(total, dt)[1:], power


def floor(power: Array) -> Array:
    """Return the white-noise variance under each row of a power spectrum.

    The spectrum is cut into up to 8 bands; the floor is the lowest of their medians, because
    a signal can only lift a band, and because a line or two cannot move a median. A band
    holds 100 frequencies or more where there are enough: the median then scatters by 14 %.
    """
    return np.asarray(np.min(_medians(power), axis=0)) / MEDIAN_OVER_MEAN


def level(power: Array) -> Array:
    """Return the white-noise variance under each row, averaged over all bands of noise alone.

    Of eight medians of the same noise the lowest is too low, by 10 % of the variance where a band
    holds 300 frequencies. So all bands that exceed it by no more than chance are averaged.
    """
    medians = np.array(_medians(power))
    scatter = MAX_DISTANCE_IN_ERRORS / (MEDIAN_OVER_MEAN * np.sqrt(power.shape[1] / len(medians)))
    near_lowest = medians <= (1.0 + scatter) * np.min(medians, axis=0)
    return np.asarray(np.mean(medians, axis=0, where=near_lowest)) / MEDIAN_OVER_MEAN


def _medians(power: Array) -> list[Array]:
    n_bands = int(np.clip(power.shape[1] // 100, 2, 8))
    return [np.median(band, axis=1) for band in np.array_split(power, n_bands, axis=1)]


def rounding(y: Array) -> Array:
    """Return the variance of the rounding error on each coarse column of y (n, k).

    A coarse encoder or converter repeats its readings. Its error is then no white noise that the
    spectrum shows near half the sampling rate. All values of such a column are whole steps apart;
    the variance is step^2 / 12. Zero for every other column.
    """
    return np.array([_rounding(column) for column in y.T])


def _rounding(y: Array) -> float:
    if np.mean(np.diff(y) == 0) < DWELL:
        return 0.0
    levels = np.unique(y) - y.min()
    gaps = np.diff(levels)
    gaps = gaps[gaps > 1e-9 * levels[-1]]
    if gaps.size == 0:
        return 0.0
    steps = levels / gaps.min()
    is_whole = np.abs(steps - np.round(steps)).max() < 0.05
    return float(gaps.min() ** 2 / 12.0) if is_whole else 0.0


def best_cutoff(frequency: Array, power: Array, noise: Array, order: int, dt: float) -> float:
    r"""Return the cutoff that best separates the derivative of this order from its noise.

    A low-pass H with cutoff f_c loses signal above it and keeps noise below it:

    .. math:: E(f_c) = \sum_f (2 \pi f)^{2m}
              \left[(1 - H)^2 (P - N) + \kappa H^2 N\right].

    Several columns add up, each relative to the size of its own derivative. The sums run over
    bands whose edges are the candidates.
    """
    noise = noise[:, None]
    weight = (frequency * dt) ** (2 * order)  # per sample, whatever the unit of time
    scale = np.sum(weight * np.maximum(power - noise, 0.0), axis=1, keepdims=True)
    scale = np.where(scale > 0, scale, 1.0)
    steps = np.geomspace(1, frequency.size, N_CANDIDATES).round().astype(int)
    starts = np.unique(np.concatenate([[0], steps[steps < frequency.size]]))
    signal_power = np.add.reduceat(np.sum(weight * (power - noise) / scale, axis=0), starts)
    noise_power = np.add.reduceat(np.sum(weight * noise / scale, axis=0), starts)
    centers = np.add.reduceat(frequency, starts) / np.diff([*starts, frequency.size])
    candidates = centers[centers < 0.49 / dt]
    gains = np.stack([gain(centers, cutoff, dt) for cutoff in candidates])
    cost = (1.0 - gains) ** 2 @ signal_power + NOISE_PRICE * gains**2 @ noise_power
    return float(candidates[np.argmin(cost)])


def auto_cutoff(y: Array, dt: float, order: int) -> float:
    """Return the cutoff for columns y (n, k), none of them constant, in cycles per unit of t."""
    y = (y - y[0]) / np.ptp(y, axis=0)
    highest = MAX_SAMPLING_RATE_SHARE / dt
    rounding_noise = rounding(y)
    lowest = min(FEWEST_PERIODS / (y.shape[0] * dt), highest)
    cutoff: float | None = None
    for _ in range(3):  # the extension of the ends depends on the cutoff
        frequency, power = spectrum(y, dt, cutoff)
        noise = np.maximum(floor(power), rounding_noise)
        best = best_cutoff(frequency, power, noise, order, dt)
        cutoff = float(np.clip(best, lowest, highest))
    return float(cutoff or highest)


def sensor_noise(y: Array, dt: float, cutoff: float | None) -> Array:
    """Return the standard deviation of the white noise on each column of y (n, k).

    Both ways to treat the ends of a record can leak a little of the signal into the floor, so the
    lower figure is taken.
    """
    variances = [level(spectrum(y, dt, cutoff_of_ends)[1]) for cutoff_of_ends in {None, cutoff}]
    return np.sqrt(np.maximum(np.min(variances, axis=0), rounding(y)))


def input_noise(u: Array, dt: float, cutoff: float | None) -> Array:
    """Return the standard deviation of the white noise on each input, u (n, k).

    Zero for an input that often repeats its values: the spectrum of its steps looks like noise. For
    an input that jumps, its smallest steps give an upper bound of the noise.
    """
    steps = np.abs(np.diff(u, axis=0))
    at_most = np.quantile(steps, NOISE_STEP_SHARE, axis=0) / (
        np.sqrt(2.0) * norm.ppf(0.5 + NOISE_STEP_SHARE / 2)
    )
    holds = np.mean(steps == 0, axis=0) >= DWELL
    return np.where(holds, 0.0, np.minimum(sensor_noise(u, dt, cutoff), at_most))


def noise_level(y: ArrayLike) -> Array | float:
    """Return the standard deviation of the white noise on each column.

    The floor is the lowest band of the spectrum (median over the band), so the noise must
    stand alone somewhere, usually near half the sampling rate; a record that is signal up to
    there gives too large a figure.

    Parameters
    ----------
    y : ndarray of shape (n_samples,) or (n_samples, n_columns)
        Signals, uniformly sampled.

    Returns
    -------
    float or ndarray of shape (n_columns,)
        Units of y.

    Raises
    ------
    ValueError
        If a value is not finite or there are fewer than 16 samples.
    TypeError
        If y is not made of real numbers.

    Examples
    --------
    >>> import numpy as np
    >>> rng = np.random.default_rng(0)
    >>> y = np.sin(np.arange(4000) / 50) + 0.01 * rng.standard_normal(4000)
    >>> round(noise_level(y), 3)
    0.01
    """
    columns = checks.columns("noise_level", "y", y)
    if columns.shape[0] < 16:
        got = f"{columns.shape[0]}"
        checks.refuse("noise_level", "y", "at least 16 samples long", got, "Record longer.")
    level = np.sqrt(floor(spectrum(columns, 1.0)[1]))
    return level if np.ndim(y) > 1 else float(level[0])
