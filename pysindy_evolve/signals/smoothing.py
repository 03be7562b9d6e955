r"""States with less noise, estimated with the help of their derivatives.

The states x and the derivatives x_dot measure one signal, as x_dot is the slope of x. So noisy
states are estimated from both, see `wiener`. A regression on the estimate has no
errors-in-variables bias, as the remaining error is not correlated with it.

References
----------
Carroll et al., Measurement Error in Nonlinear Models, 2006, chapter 4 (regression calibration).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import fft, optimize

from .bands import lowest_quarter
from .spectral import Array
from .wiener import MAX_QUIET_NOISE, estimate

N_PROBES, PROBE_ROWS = 8, 512  # number and rows of the stretches that are checked for noise
LEAST_ROWS = 256  # fewer rows do not give a usable spectrum
COHERENT = 0.9  # least coherence of x_dot with the slope of x in a uniform time series
# Radians per row (six rows a period): largest median of the loud frequencies. If x_dot is really
# the next value of a map, its phase is then off by 30 degrees or more, and coherence is too low.
MAX_OMEGA = np.pi / 3.0
LOUD = 0.5  # share of the power of x_dot in the loud frequencies, which give the sampling time


@dataclass(frozen=True, eq=False)
class Smoothed:
    """Columns of one trajectory with less noise.

    Attributes
    ----------
    x : ndarray of shape (n_samples, n_columns)
        States and inputs, in the user's units.
    noise : ndarray of shape (n_columns,)
        Standard deviation of the remaining noise of each.
    ends : int
        Rows at each end that are not improved.
    """

    x: Array
    noise: Array
    ends: int


def is_noisy(x: Array) -> bool:
    """Tell whether a column of x (n, k), in order of time, has white noise that does harm.

    Differences of sixth order remove a well-sampled signal; their median over the rows ignores
    jumps. The cost is that of a few thousand rows.
    """
    return bool(np.any(_roughness(x) > MAX_QUIET_NOISE))


def _roughness(x: Array) -> Array:
    """Return the noise of each column by sixth differences, as a share of its RMS."""
    starts = np.linspace(0, max(len(x) - PROBE_ROWS, 0), N_PROBES).astype(int)
    probes = [x[a : a + PROBE_ROWS] for a in dict.fromkeys(starts.tolist())]
    differences = np.concatenate([np.abs(np.diff(part, n=6, axis=0)) for part in probes])
    rms = np.sqrt(np.mean([np.mean(np.square(part), axis=0) for part in probes], axis=0))
    # Sixth differences of unit white noise have variance 924; the median of |normal| is 0.6745.
    noise = np.median(differences, axis=0) / (0.6745 * np.sqrt(924.0))
    return np.asarray(noise / np.where(rms > 0.0, rms, 1.0))


def time_step(x: Array, x_dot: Array) -> float | None:
    """Estimate the sampling time of states from their derivatives.

    Parameters
    ----------
    x, x_dot : ndarray of shape (n_samples, n_states)
        States and derivatives.

    Returns
    -------
    float or None
        Units of t; None if x_dot is not the slope of x from row to row, as where rows are out of
        order, or not sampled uniformly, and if no derivative varies.
    """
    n = len(x)
    fading = _faded(np.ones(n))
    pairs = [
        (
            _without_mean(_faded_slope(state), fading),
            _without_mean(_faded(rate), fading),
            _faded(state),
        )
        for state, rate in zip(x.T, x_dot.T, strict=True)
        if np.ptp(rate) > 0.0 and np.ptp(state) > 0.0
    ]
    if not pairs:
        return None
    loud_bins = [_loud_bins(rate) for _, rate, _ in pairs]
    if any(np.median(_omega(n)[bins]) > MAX_OMEGA for bins in loud_bins):
        return None
    norms = [
        np.linalg.norm([slope[bins], rate[bins]], axis=1)
        for (slope, rate, _), bins in zip(pairs, loud_bins, strict=True)
    ]
    guess = float(np.exp(np.mean([np.log(slope / rate) for slope, rate in norms])))
    for (slope, rate, _), bins in zip(pairs, loud_bins, strict=True):
        product = float(np.sum((slope[bins] * np.conj(rate[bins])).real))
        if product < COHERENT * np.linalg.norm(slope[bins]) * np.linalg.norm(rate[bins]):
            return None
    noise_powers = [(_white_power(rate), _white_power(state)) for _, rate, state in pairs]
    n_bins = 2 + max(int(bins.max()) for bins in loud_bins)  # above, there is only noise

    def misfit(share: float) -> float:
        """Return the squared differences over their noise; least at the true sampling time."""
        total = 0.0
        for (slope, rate, _), (rate_noise, state_noise) in zip(pairs, noise_powers, strict=True):
            noise = _omega(n)[1:n_bins] ** 2 * state_noise + (share * guess) ** 2 * rate_noise
            total += float(
                np.sum(np.abs(slope[1:n_bins] - share * guess * rate[1:n_bins]) ** 2 / noise)
            )
        return total

    best = optimize.minimize_scalar(misfit, bounds=(0.9, 1.1), method="bounded")
    return float(best.x) * guess


def _without_mean(
    spectrum: NDArray[np.complex128], fading: NDArray[np.complex128]
) -> NDArray[np.complex128]:
    """Remove the mean from a faded spectrum: means always agree in phase, and prove nothing."""
    return spectrum - spectrum[0] / fading[0] * fading


def _white_power(spectrum: NDArray[np.complex128]) -> float:
    power = np.abs(spectrum) ** 2
    return lowest_quarter(power, np.ones(len(power), dtype=int))


def _loud_bins(spectrum: NDArray[np.complex128]) -> NDArray[np.intp]:
    """Return the loudest bins, which together hold half of the power."""
    power = np.abs(spectrum) ** 2
    order = np.argsort(power)[::-1]
    cumulated = np.cumsum(power[order])
    return order[: int(np.searchsorted(cumulated, LOUD * cumulated[-1])) + 1]


def _faded(y: Array) -> NDArray[np.complex128]:
    """Return the spectrum of a column that is faded in and out (Hann)."""
    return _spectrum(y * np.sin(_half_turn(len(y))) ** 2)


def _faded_slope(y: Array) -> NDArray[np.complex128]:
    """Return the faded spectrum of the slope per sample, without taking a difference.

    As (w y)' = w' y + w y', the part w' y of the fading w is subtracted.
    """
    n = len(y)
    centered = y - y.mean()
    from_fading = centered * np.sin(2.0 * _half_turn(n)) * np.pi / n
    return 1j * _omega(n) * _faded(centered) - _spectrum(from_fading)


def _spectrum(y: Array) -> NDArray[np.complex128]:
    return np.asarray(fft.rfft(y, fft.next_fast_len(len(y), real=True)))


def _omega(n: int) -> Array:
    return np.asarray(2.0 * np.pi * fft.rfftfreq(fft.next_fast_len(n, real=True)))


def _half_turn(n: int) -> Array:
    return np.asarray(np.pi * (np.arange(n) + 0.5) / n)


def smooth_states(x: Array, x_dot: Array) -> Smoothed | None:
    """Estimate states and inputs from noisy measurements of them and of the derivatives.

    Parameters
    ----------
    x : ndarray of shape (n_samples, n_states + n_inputs)
        One trajectory, rows in order of time and evenly sampled.
    x_dot : ndarray of shape (n_samples, n_states)
        Derivatives of the first columns of x.

    Returns
    -------
    Smoothed or None
        None if no noise does harm, or if the rows are no uniform time series.

    Notes
    -----
    The cost is a few FFTs of 2 n samples for each column.
    """
    n_states = x_dot.shape[1]
    if len(x) < LEAST_ROWS or not is_noisy(x):
        return None
    dt = time_step(x[:, :n_states], x_dot)
    if dt is None:
        return None
    smooth, noise, ends = x.copy(), np.zeros(x.shape[1]), 0
    for columns in _chains(x, x_dot):
        last_column = columns[-1]
        levels = [x[:, j] for j in columns]
        levels += [x_dot[:, last_column]] if last_column < n_states else []
        scaled = np.column_stack([level * dt**m for m, level in enumerate(levels)])
        estimated, noise_left, end_rows = estimate(scaled)
        ends = max(ends, end_rows)
        for m, j in enumerate(columns):
            smooth[:, j], noise[j] = estimated[:, m] / dt**m, noise_left[m] / dt**m
    return Smoothed(smooth, noise, ends)


def _chains(x: Array, x_dot: Array) -> list[list[int]]:
    """Group columns of x into chains: each column is the derivative of the one before, by x_dot."""
    n_states = x_dot.shape[1]
    derivative_of = {
        i: j
        for i in range(n_states)
        for j in range(n_states)
        if i != j and np.array_equal(x_dot[:, i], x[:, j])
    }
    chains, free = [], set(range(x.shape[1]))
    firsts = [j for j in range(x.shape[1]) if j not in derivative_of.values()]
    for first in [*firsts, *range(x.shape[1])]:
        chain: list[int] = []
        column: int | None = first
        while column is not None and column in free:
            free.remove(column)
            chain.append(column)
            column = derivative_of.get(column)
        if chain:
            chains.append(chain)
    return chains
