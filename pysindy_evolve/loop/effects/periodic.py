"""Periodic forcing and ripple: sines and cosines where a residual has a line in its spectrum."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial

import numpy as np
from scipy import fft
from scipy.ndimage import median_filter
from scipy.stats import binned_statistic

from ...operators import BUILTIN
from ...terms import Sum, call, constant, mul, variable
from .candidate import Candidate, CandidateMaker, Shape

__all__ = [
    "FEWEST_FREQUENCIES",
    "N_LINES",
    "frequency_of",
    "is_same_ripple",
    "lines_of",
    "periodic_candidates",
    "pumped_candidates",
    "ripple_candidates",
]

FORCING = "periodic forcing"
FREQUENCY = "angular frequency"
FINENESS = 8  # of the grid of frequencies: the true one lies close to it
N_LINES = 2  # that are looked at in an equation
LINE = 5.0  # prominence that makes a peak a line; noise reaches three to four
HALF = FINENESS // 2  # of these make half of what the record resolves
AROUND, SKIRT = 10, 2  # frequencies of the record about a line that say what inputs do, but these
SURROUNDINGS = 81  # half frequencies of the record, about a place, whose median is the noise there
FEWEST_FREQUENCIES = SURROUNDINGS // 2  # in the band of a record, to know the noise about a line
PERIODS_IN_TIME = 8  # of a line in a record, at least; fewer look like slow disturbances
PERIODS_IN_SPACE = 4  # fewer within the stroke look like a spring or a slope
SAMPLES_PER_BIN = 8  # of the stroke, on average: as fine as the record can tell


def periodic_candidates(
    state: int,
    time: int,
    residual: np.ndarray,
    drivers: np.ndarray,
    dt: float,
    highest: float = np.inf,
) -> list[Candidate]:
    """Return sines and cosines of time at the strongest frequencies of a residual.

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
    highest : float
        Frequency up to which to look, cycles per unit of t, such as the cutoff of a low-pass.

    Returns
    -------
    list of Candidate
    """
    effect = CandidateMaker(state)
    return [
        effect(FORCING, shape=_of_line(frequency, len(residual) * dt, _waves(time), branch))
        for branch, frequency in enumerate(lines_of(residual, drivers, dt, highest))
    ]


def pumped_candidates(
    state: int,
    time: int,
    residual: np.ndarray,
    part: Sum,
    values: np.ndarray,
    drivers: np.ndarray,
    dt: float,
    highest: float = np.inf,
    *,
    branch: int = 0,
) -> list[Candidate]:
    """Return a declared term times sines and cosines of time: a stiffness that is pumped.

    What such a term leaves is a line where it is multiplied by the term itself.

    Parameters
    ----------
    state, time, residual, drivers, dt, highest
        As in `periodic_candidates`.
    part : Sum
        The term, without its coefficient.
    values : ndarray of shape (n_samples,)
        Its values.
    branch : int
        Tells the term from the others of its equation.

    Returns
    -------
    list of Candidate
        One or none.
    """
    effect, others = CandidateMaker(state), np.column_stack([drivers, values, values**2])
    waves = tuple(partial(_times, part, wave) for wave in _waves(time))
    length = len(residual) * dt
    return [
        effect(FORCING, shape=_of_line(line, length, waves, branch), parents=(part,), alone=True)
        for line in lines_of(residual * values, others, dt, highest, n_peaks=1)
    ]


def _of_line(
    frequency: float, length: float, waves: tuple[Callable[[float], Sum], ...], branch: int
) -> Shape:
    """Return waves at a frequency, to be tuned by half of what a record of a length resolves."""
    reach = 0.5 / (frequency * length)
    return Shape((2 * np.pi * frequency,), waves, reach, (FREQUENCY,), branch)


def _times(part: Sum, wave: Callable[[float], Sum], frequency: float) -> Sum:
    return mul(part, wave(frequency))


def frequency_of(candidate: Candidate) -> float:
    """Return the frequency of a periodic forcing, cycles per unit of t; zero of another effect."""
    if candidate.shape is None or FREQUENCY not in candidate.shape.meanings:
        return 0.0
    return candidate.shape.named[FREQUENCY] / (2 * np.pi)


def lines_of(
    residual: np.ndarray,
    drivers: np.ndarray,
    dt: float,
    highest: float = np.inf,
    *,
    n_peaks: int = N_LINES,
) -> list[float]:
    """Return the frequencies, cycles per unit of t, of lines of a residual that no input has.

    Parameters
    ----------
    residual, drivers, dt, highest
        As in `periodic_candidates`.
    n_peaks : int
        How many to return at most.

    Returns
    -------
    list of float
        The clearest first.
    """
    found = _lines(residual, drivers.T, PERIODS_IN_TIME, n_peaks, highest * dt)
    return [cycles / dt for cycles in found]


def ripple_candidates(
    state: int,
    position: int,
    residual: np.ndarray,
    q: np.ndarray,
    noise: float = 0.0,
) -> list[Candidate]:
    """Return sine and cosine of a position at the strongest wave number of a residual.

    Cogging of a motor, teeth of a gear and the pitch of a screw come again at the same places,
    whenever the machine passes there. So the residual is averaged over short pieces of the stroke
    first. What is finer than the noise of the position is no place: the steps of an encoder come
    again at the same places as well, in its readings.

    Parameters
    ----------
    state : int
        Equation that the residual belongs to.
    position : int
        Column of the variables that holds the position.
    residual : ndarray of shape (n_samples,)
        What the model leaves.
    q : ndarray of shape (n_samples,)
        Position.
    noise : float
        Standard deviation of the noise of the sensor of the position.

    Returns
    -------
    list of Candidate
        One, or none.
    """
    n_bins = len(q) // SAMPLES_PER_BIN
    if n_bins < 2 * PERIODS_IN_SPACE or np.ptp(q) == 0.0:
        return []
    mean, edges, _ = binned_statistic(q, residual, "mean", n_bins)
    seen = np.isfinite(mean)
    mean = np.interp(np.arange(n_bins), np.flatnonzero(seen), mean[seen])
    effect, width = CandidateMaker(state), float(edges[1] - edges[0])
    finest = width / (2 * np.pi * noise) if noise > 0.0 else np.inf
    lines = _lines(mean, (), PERIODS_IN_SPACE, 1, finest)
    return [
        effect(
            "position-periodic ripple",
            # Pieces that were passed less often bend the line; it is half a period wide each way.
            shape=Shape(
                (2 * np.pi * cycles / width,),
                _waves(position),
                0.5 / (n_bins * cycles),
                ("wave number",),
            ),
        )
        for cycles in lines
    ]


def is_same_ripple(one: Candidate, other: Candidate) -> bool:
    """Tell whether either of two ripples can be tuned to the wave number of the other."""
    if one.shape is None or other.shape is None:
        return False
    apart = abs(np.log(one.shape.values[0] / other.shape.values[0]))
    return bool(apart <= max(one.shape.reach, other.shape.reach))


def _waves(column: int) -> tuple[Callable[[float], Sum], ...]:
    """Return what builds a sine and a cosine of a variable from a frequency, radians a unit."""
    return partial(_wave, "sin", column), partial(_wave, "cos", column)


def _wave(function: str, column: int, frequency: float) -> Sum:
    return call(BUILTIN[function], mul(constant(frequency), variable(column)))


def _lines(
    signal: np.ndarray,
    others: Sequence[np.ndarray] | np.ndarray,
    n_periods: int,
    n_peaks: int,
    highest: float = np.inf,
) -> Iterator[float]:
    """Yield frequencies of lines that no other signal has, cycles a sample, the clearest first.

    Lines stand out of noise that may be much stronger elsewhere. Each is subtracted before the next
    is looked for, so that its skirts are no lines.
    """
    if not np.isfinite(signal).all():  # the root of a level, in a twin that runs dry
        return
    n_fine = FINENESS * fft.next_fast_len(len(signal), real=True)
    places = np.arange(n_fine // 2 + 1)
    free = (places > FINENESS * n_periods) & (places < highest * n_fine)
    n_found, whole = 0, signal
    while n_found < n_peaks:
        spectrum, floor = _spectrum_and_floor(signal, n_fine)
        peak = int(np.argmax(np.where(free, spectrum / floor, 0.0)))
        if not free[peak] or spectrum[peak] < LINE * floor[peak]:
            break
        cycles = _vertex(spectrum, peak) / n_fine
        # A peak that begins to rise where the search does belongs to what is too slow for a line.
        its_own = cycles * n_fine > FINENESS * n_periods - 1 and not any(
            _has_line(*_spectrum_and_floor(other, n_fine), peak) for other in others
        )
        if its_own and not _is_response(whole, others, peak, n_fine):
            yield cycles
            n_found += 1
        free[max(peak - FINENESS, 0) : peak + FINENESS + 1] = False
        signal = _without(signal, cycles)


def _without(signal: np.ndarray, cycles: float) -> np.ndarray:
    """Return a signal without its mean and its part at a frequency."""
    phase = 2 * np.pi * cycles * np.arange(len(signal))
    waves = np.column_stack([np.ones(len(signal)), np.sin(phase), np.cos(phase)])
    taper = np.hanning(len(signal))
    coef = np.linalg.lstsq(waves * taper[:, None], signal * taper, rcond=None)[0]
    return np.asarray(signal - waves @ coef)


def _spectrum_and_floor(signal: np.ndarray, n_fine: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the amplitude spectrum, finer than the record gives, and its median around."""
    spectrum = np.abs(_transform(signal, n_fine))
    places = np.arange(len(spectrum))
    coarse = places[::HALF]
    floor = median_filter(spectrum[coarse], SURROUNDINGS)
    return spectrum, np.maximum(np.interp(places, coarse, floor), 1e-300)


def _transform(signal: np.ndarray, n_fine: int) -> np.ndarray:
    """Return the complex spectrum of a signal without its mean, tapered and padded with zeros."""
    return np.asarray(fft.rfft((signal - signal.mean()) * np.hanning(len(signal)), n_fine))


def _is_response(
    signal: np.ndarray, others: Sequence[np.ndarray] | np.ndarray, peak: int, n_fine: int
) -> bool:
    """Tell whether half of a line is what the frequencies around it let expect of the inputs.

    There a response is the spectrum of each input times a quadratic function of the frequency
    (local polynomial method: Schoukens et al., Eur. J. Control 15 (2009),
    DOI 10.3166/ejc.15.260-274).
    """
    near = np.arange(peak % HALF, n_fine // 2 + 1, HALF)
    near = near[np.abs(near - peak) <= AROUND * FINENESS]
    apart = (near - peak) / (AROUND * FINENESS)
    spectra = [_transform(other, n_fine)[near] for other in others]
    if not spectra:
        return False
    basis = np.column_stack([spectrum * apart**k for spectrum in spectra for k in range(3)])
    line = _transform(signal, n_fine)[near]
    away, at = np.abs(apart) > SKIRT / AROUND, near == peak
    response = basis[at] @ np.linalg.lstsq(basis[away], line[away], rcond=None)[0]
    return bool(np.all(np.abs(line[at] - response) < 0.5 * np.abs(line[at])))


def _vertex(spectrum: np.ndarray, peak: int) -> float:
    """Return the place of a peak between grid points, from the parabola through three of them."""
    if not 0 < peak < len(spectrum) - 1:
        return float(peak)
    left, top, right = np.log(np.maximum(spectrum[peak - 1 : peak + 2], 1e-300))
    bend = left - 2.0 * top + right
    return peak + (0.5 * float((left - right) / bend) if bend < 0.0 else 0.0)


def _has_line(spectrum: np.ndarray, floor: np.ndarray, peak: int) -> bool:
    """Tell whether a spectrum has a line of its own at a place, not only the skirt of another."""
    start = max(peak - FINENESS, 0)
    near = spectrum[start : peak + FINENESS + 1]
    top = int(np.argmax(near))
    return 0 < top < len(near) - 1 and bool(near[top] >= LINE * floor[start + top])
