"""Periodic forcing: sines and cosines at the frequencies at which a residual has a line."""

from __future__ import annotations

import numpy as np
from scipy import fft

from ..operators import BUILTIN
from ..terms import call, constant, mul, variable
from .candidate import Candidate

__all__ = ["periodic_candidates"]

FINENESS = 8  # of the grid of frequencies: the true one lies close to it
LINE = 5.0  # prominence that makes a peak a line; noise reaches three to four


def periodic_candidates(
    state: int,
    time: int,
    residual: np.ndarray,
    drivers: np.ndarray,
    dt: float,
    n_peaks: int = 2,
) -> list[Candidate]:
    """Return sines and cosines at the strongest frequencies of a residual.

    A line that an input has too is no forcing of its own, but a response to the input that the
    model gets wrong, and is left out.

    Parameters
    ----------
    state : int
        Equation that the residual belongs to.
    time : int
        Column of the variables that holds time.
    residual : ndarray of shape (n_samples,)
        On a uniform grid of step dt.
    drivers : ndarray of shape (n_samples, n_inputs)
        Inputs.
    dt : float
        Sampling time, units of t.
    n_peaks : int
        How many frequencies to propose.

    Returns
    -------
    list of Candidate
    """
    n_fine = FINENESS * fft.next_fast_len(len(residual), real=True)
    spectrum = _fine_spectrum(residual, n_fine)
    inputs = [_fine_spectrum(column, n_fine) for column in drivers.T]
    lowest = FINENESS * 8  # fewer than eight periods in the record look like slow disturbances
    found: list[Candidate] = []
    while len(spectrum) > lowest + 1 and len(found) < n_peaks:
        peak = lowest + int(np.argmax(spectrum[lowest:]))
        if _prominence(spectrum, peak) < LINE:
            break
        if all(_prominence(driver, peak) < LINE for driver in inputs):
            cycles = _vertex(spectrum, peak) / (n_fine * dt)
            phase = mul(constant(2 * np.pi * cycles), variable(time))
            terms = (call(BUILTIN["sin"], phase), call(BUILTIN["cos"], phase))
            found.append(Candidate("periodic forcing", state, terms))
        spectrum[max(peak - 2 * FINENESS, 0) : peak + 2 * FINENESS + 1] = 0.0
    return found


def _fine_spectrum(signal: np.ndarray, n_fine: int) -> np.ndarray:
    """Return the amplitude spectrum on a grid that is eight times finer than the record gives."""
    centered = (signal - signal.mean()) * np.hanning(len(signal))
    return np.asarray(np.abs(fft.rfft(centered, n_fine)))


def _vertex(spectrum: np.ndarray, peak: int) -> float:
    """Return the place of a peak between grid points, from the parabola through three of them."""
    if not 0 < peak < len(spectrum) - 1:
        return float(peak)
    left, top, right = np.log(np.maximum(spectrum[peak - 1 : peak + 2], 1e-300))
    bend = left - 2.0 * top + right
    return peak + (0.5 * float((left - right) / bend) if bend < 0.0 else 0.0)


def _prominence(spectrum: np.ndarray, peak: int) -> float:
    """Return how far a line stands out of its surroundings, as a ratio of amplitudes."""
    near = slice(max(peak - FINENESS // 2, 0), peak + FINENESS // 2 + 1)
    wide = spectrum[max(peak - 20 * FINENESS, 0) : peak + 20 * FINENESS + 1]
    return float(spectrum[near].max() / max(np.median(wide), 1e-300))
