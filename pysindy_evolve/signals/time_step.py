"""The sampling time of states, estimated from their derivatives.

A derivative is the slope of its state per unit of t. So the slope per sample, over the derivative,
is the sampling time.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import fft, optimize

from .bands import lowest_quarter
from .spectral import Array

Spectrum = NDArray[np.complex128]

COHERENT = 0.9  # least coherence of x_dot with the slope of x in a uniform time series
# Radians per row (six rows a period): largest median of the loud frequencies. If x_dot is really
# the next value of a map, its phase is then off by 30 degrees or more, and coherence is too low.
MAX_OMEGA = np.pi / 3.0
FADE = 0.02  # share of the record, half at each end, over which it fades in and out
LOUD = 0.5  # share of the power of x_dot in the loud frequencies, which give the sampling time


@dataclass(frozen=True, eq=False)
class _Spectra:
    """Spectra of one state, faded in and out.

    Attributes
    ----------
    slope, rate : ndarray of shape (n_frequencies,)
        Slope of the state per sample, and its derivative, without their means.
    state : ndarray of shape (n_frequencies,)
        The state itself.
    loud : ndarray of int
        The loudest bins of the derivative.
    """

    slope: Spectrum
    rate: Spectrum
    state: Spectrum
    loud: NDArray[np.intp]

    @classmethod
    def of(cls, state: Array, rate: Array) -> _Spectra:
        """Return the spectra of a state and its derivative, each (n_samples,)."""
        fading = _faded(np.ones(len(state)))
        slope = _without_mean(_faded_slope(state), fading)
        varying = _without_mean(_faded(rate), fading)
        return cls(slope, varying, _faded(state), _loud_bins(varying))

    @property
    def is_coherent(self) -> bool:
        """Whether slope and derivative have the same phase where they are loud."""
        slope, rate = self.slope[self.loud], self.rate[self.loud]
        product = float(np.sum((slope * np.conj(rate)).real))
        return bool(product >= COHERENT * np.linalg.norm(slope) * np.linalg.norm(rate))


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
    spectra = [
        _Spectra.of(state, rate)
        for state, rate in zip(x.T, x_dot.T, strict=True)
        if np.ptp(rate) > 0.0 and np.ptp(state) > 0.0
    ]
    omega = _omega(len(x))
    if not spectra or any(np.median(omega[one.loud]) > MAX_OMEGA for one in spectra):
        return None
    norms = [np.linalg.norm([one.slope[one.loud], one.rate[one.loud]], axis=1) for one in spectra]
    guess = float(np.exp(np.mean([np.log(slope / rate) for slope, rate in norms])))
    if not all(one.is_coherent for one in spectra):
        return None
    return _best_share(guess, spectra, len(x)) * guess


def _best_share(guess: float, spectra: Sequence[_Spectra], n: int) -> float:
    """Return the share of a guess at which slopes and derivatives differ least over their noise."""
    noise_powers = [(_white_power(one.rate), _white_power(one.state)) for one in spectra]
    n_bins = 2 + max(int(one.loud.max()) for one in spectra)  # above, there is only noise
    slope_noise = _noise_of_slope(n)

    def misfit(share: float) -> float:
        """Return the squared differences over their noise; least at the true sampling time."""
        total = 0.0
        for one, (rate_noise, state_noise) in zip(spectra, noise_powers, strict=True):
            noise = slope_noise[1:n_bins] * state_noise + (share * guess) ** 2 * rate_noise
            difference = one.slope[1:n_bins] - share * guess * one.rate[1:n_bins]
            total += float(np.sum(np.abs(difference) ** 2 / noise))
        return total

    best = optimize.minimize_scalar(misfit, bounds=(0.9, 1.1), method="bounded")
    return float(best.x)


def _without_mean(spectrum: Spectrum, fading: Spectrum) -> Spectrum:
    """Remove the mean from a faded spectrum: means always agree in phase, and prove nothing."""
    return spectrum - spectrum[0] / fading[0] * fading


def _white_power(spectrum: Spectrum) -> float:
    power = np.abs(spectrum) ** 2
    return lowest_quarter(power, np.ones(len(power), dtype=int))


def _loud_bins(spectrum: Spectrum) -> NDArray[np.intp]:
    """Return the loudest bins, which together hold half of the power."""
    power = np.abs(spectrum) ** 2
    order = np.argsort(power)[::-1]
    cumulated = np.cumsum(power[order])
    return order[: int(np.searchsorted(cumulated, LOUD * cumulated[-1])) + 1]


def _faded(y: Array) -> Spectrum:
    """Return the spectrum of a column that is faded in and out."""
    window, _ = _fading(len(y))
    return _spectrum(window * y)


def _faded_slope(y: Array) -> Spectrum:
    """Return the faded spectrum of the slope per sample, without taking a difference.

    As (w y)' = w' y + w y', the part w' y of the fading w is subtracted.
    """
    centered = y - y.mean()
    _, slope = _fading(len(y))
    return 1j * _omega(len(y)) * _faded(centered) - _spectrum(slope * centered)


def _noise_of_slope(n: int) -> Array:
    """Return the noise power of the faded slope where that of the faded state is one.

    White noise e in the state is (w e)' - w' e in the slope, of power sum(omega^2 w^2 + w'^2).
    """
    window, slope = _fading(n)
    return _omega(n) ** 2 + (slope @ slope) / (window @ window)


def _fading(n: int) -> tuple[Array, Array]:
    """Return the window that fades a record in and out, and its slope per row, each (n,)."""
    rows = np.arange(n) + 0.5
    fading_rows = 0.5 * FADE * n
    phase = 0.5 * np.pi * np.minimum(np.minimum(rows, n - rows) / fading_rows, 1.0)
    slope = np.sign(n - 2.0 * rows) * np.sin(2.0 * phase) * 0.5 * np.pi / fading_rows
    return np.sin(phase) ** 2, slope


def _spectrum(y: Array) -> Spectrum:
    return np.asarray(fft.rfft(y, fft.next_fast_len(len(y), real=True)))


def _omega(n: int) -> Array:
    return np.asarray(2.0 * np.pi * fft.rfftfreq(fft.next_fast_len(n, real=True)))
