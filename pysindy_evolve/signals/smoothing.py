r"""States freed from their noise by what their derivatives say.

A row of x and one of x_dot are two measurements of one signal: x_dot is its slope. So noisy states
are estimated from both, see `wiener`. A regression on the estimate has no errors-in-variables bias,
as what is left of the noise does not go with it.

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
from .wiener import QUIET, estimate

__all__ = ["Smoothed", "is_noisy", "smooth_states", "time_step"]

PROBES, PROBE = 8, 512  # stretches of so many rows tell whether there is noise at all
LEAST_ROWS = 256  # fewer rows have no spectrum to speak of
COHERENT = 0.9  # of x and x_dot, from which on rows are taken for an even time series
# Radians a row, for most of what is loud: six rows a period. If x_dot is really the next value of a
# map, its phase is off by 30 degrees or more there, and the test of coherence fails.
FASTEST = np.pi / 3.0
LOUD = 0.5  # share of the power of x_dot in the frequencies that the sampling time is found from


@dataclass(frozen=True, eq=False)
class Smoothed:
    """Columns of one trajectory, freed from noise.

    Attributes
    ----------
    x : ndarray of shape (n_samples, n_columns)
        States and inputs, in the user's units.
    noise : ndarray of shape (n_columns,)
        Standard deviation of the noise that is left in each.
    ends : int
        Rows at each end that are not better than they were measured.
    """

    x: Array
    noise: Array
    ends: int


def is_noisy(x: Array) -> bool:
    """Tell whether a column of x (n, k), in order of time, carries white noise that does harm.

    Differences of sixth order leave nothing of a signal that was sampled well; their median over
    the rows ignores jumps. A clean column, or rows in no order, give a clear answer at the cost of
    a few thousand rows.
    """
    return bool(np.any(_roughness(x) > QUIET))


def _roughness(x: Array) -> Array:
    """Return the noise of each column by sixth differences, as a share of its RMS."""
    starts = np.linspace(0, max(len(x) - PROBE, 0), PROBES).astype(int)
    parts = [x[a : a + PROBE] for a in dict.fromkeys(starts.tolist())]
    rough = np.concatenate([np.abs(np.diff(part, n=6, axis=0)) for part in parts])
    size = np.sqrt(np.mean([np.mean(np.square(part), axis=0) for part in parts], axis=0))
    # White noise of variance one: sixth differences have 924, and 0.6745 is a normal's quartile.
    noise = np.median(rough, axis=0) / (0.6745 * np.sqrt(924.0))
    return np.asarray(noise / np.where(size > 0.0, size, 1.0))


def time_step(x: Array, x_dot: Array) -> float | None:
    """Find the sampling time of states from their derivatives.

    Parameters
    ----------
    x, x_dot : ndarray of shape (n_samples, n_states)
        States and derivatives.

    Returns
    -------
    float or None
        Units of t; None where x_dot is not the slope of x from row to row: rows out of order, or
        sampled unevenly.
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
    loud = [_loud(rate) for _, rate, _ in pairs]
    if any(np.median(_omega(n)[at]) > FASTEST for at in loud):
        return None
    sizes = [
        np.linalg.norm([slope[at], rate[at]], axis=1)
        for (slope, rate, _), at in zip(pairs, loud, strict=True)
    ]
    first = float(np.exp(np.mean([np.log(slope / rate) for slope, rate in sizes])))
    for (slope, rate, _), at in zip(pairs, loud, strict=True):
        product = float(np.sum((slope[at] * np.conj(rate[at])).real))
        if product < COHERENT * np.linalg.norm(slope[at]) * np.linalg.norm(rate[at]):
            return None
    powers = [(_white(rate), _white(state)) for _, rate, state in pairs]
    top = 2 + max(int(at.max()) for at in loud)  # there is nothing to learn from noise

    def misfit(share: float) -> float:
        """Sum of squared differences in units of their noise, which is least at the truth."""
        total = 0.0
        for (slope, rate, _), (of_rate, of_state) in zip(pairs, powers, strict=True):
            noise = _omega(n)[1:top] ** 2 * of_state + (share * first) ** 2 * of_rate
            total += float(np.sum(np.abs(slope[1:top] - share * first * rate[1:top]) ** 2 / noise))
        return total

    found = optimize.minimize_scalar(misfit, bounds=(0.9, 1.1), method="bounded")
    return float(found.x) * first


def _without_mean(
    spectrum: NDArray[np.complex128], fading: NDArray[np.complex128]
) -> NDArray[np.complex128]:
    """Take the mean of what was faded out of its spectrum: two means always agree in phase."""
    return spectrum - spectrum[0] / fading[0] * fading


def _white(spectrum: NDArray[np.complex128]) -> float:
    power = np.abs(spectrum) ** 2
    return lowest_quarter(power, np.ones(len(power), dtype=int))


def _loud(spectrum: NDArray[np.complex128]) -> NDArray[np.intp]:
    """Return the frequencies that hold half of the power."""
    power = np.abs(spectrum) ** 2
    order = np.argsort(power)[::-1]
    share = np.cumsum(power[order])
    return order[: int(np.searchsorted(share, LOUD * share[-1])) + 1]


def _faded(y: Array) -> NDArray[np.complex128]:
    """Return the spectrum of a column that is faded in and out (Hann)."""
    return _spectrum(y * np.sin(_half_turn(len(y))) ** 2)


def _faded_slope(y: Array) -> NDArray[np.complex128]:
    """Return the faded spectrum of the slope per sample, without taking a difference.

    (w y)' = w' y + w y', so what the fading itself does is taken off.
    """
    n = len(y)
    rest = y - y.mean()
    fading = rest * np.sin(2.0 * _half_turn(n)) * np.pi / n
    return 1j * _omega(n) * _faded(rest) - _spectrum(fading)


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
        None where there is no noise that does harm, or where the rows are no time series.

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
        last = columns[-1]
        levels = [x[:, j] for j in columns]
        levels += [x_dot[:, last]] if last < n_states else []
        scaled = np.column_stack([level * dt**m for m, level in enumerate(levels)])
        best, left, end = estimate(scaled)
        ends = max(ends, end)
        for m, j in enumerate(columns):
            smooth[:, j], noise[j] = best[:, m] / dt**m, left[m] / dt**m
    return Smoothed(smooth, noise, ends)


def _chains(x: Array, x_dot: Array) -> list[list[int]]:
    """Group columns of x: each is the derivative of the one before, as x_dot says."""
    n_states = x_dot.shape[1]
    following = {
        i: j
        for i in range(n_states)
        for j in range(n_states)
        if i != j and np.array_equal(x_dot[:, i], x[:, j])
    }
    chains, free = [], set(range(x.shape[1]))
    firsts = [j for j in range(x.shape[1]) if j not in following.values()]
    for first in [*firsts, *range(x.shape[1])]:
        chain: list[int] = []
        at: int | None = first
        while at is not None and at in free:
            free.remove(at)
            chain.append(at)
            at = following.get(at)
        if chain:
            chains.append(chain)
    return chains
