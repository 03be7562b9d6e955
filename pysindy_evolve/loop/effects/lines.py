"""Lines in the spectrum of a signal: frequencies at which it stands out of the noise."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cache, lru_cache

import numpy as np
from scipy import fft
from scipy.ndimage import median_filter

from ...checks import TINY

FINENESS = 4  # grid points per frequency that the record resolves
LINE = 5.0  # ratio to the noise floor that makes a peak a line; noise reaches three to four
ROUGHLY = 0.8  # of it, that a coarse grid shows of any line; a Hann window has 0.85
VALLEYS, COMB = 0.1, 15.0  # quantile around a place, and ratio to it that makes a line of a comb
MIN_COMB_SHARE = 0.2  # of the largest line, that other lines of a comb have at least
MOST_TRIED = 16  # peaks; after as many lines of inputs, only their skirts are left
POINTS_PER_HALF_FREQUENCY = FINENESS // 2  # grid points per half frequency of the record
AROUND, SKIRT = 10, 2  # frequencies about a line that predict a response, nearer ones do not
SURROUNDINGS = 81  # half frequencies around a place, whose median is the noise floor
FEWEST_FREQUENCIES = SURROUNDINGS // 2  # in the band of a record, to know its noise floor


def find_lines(
    signal: np.ndarray,
    others: Sequence[np.ndarray] | np.ndarray,
    n_periods: int,
    n_peaks: int,
    highest: float = np.inf,
) -> Iterator[float]:
    """Yield frequencies of lines that no other signal has, cycles a sample, the clearest first.

    Parameters
    ----------
    signal : ndarray of shape (n,)
        Uniformly sampled.
    others : sequence of ndarray of shape (n,)
        Signals whose lines, and the responses to them, do not count.
    n_periods : int
        Periods of a line in the signal, at least.
    n_peaks : int
        How many to yield at most.
    highest : float
        Frequency up to which to look, cycles a sample.

    Yields
    ------
    float

    Notes
    -----
    Lines stand out of noise that may be much stronger elsewhere. Each is subtracted before the next
    is looked for, so that its skirts are no lines.
    """
    if not np.isfinite(signal).all():  # such as the root of a level, in a twin that runs dry
        return
    n_fine = FINENESS * fft.next_fast_len(len(signal), real=True)
    places = np.arange(n_fine // 2 + 1)
    free = (places > FINENESS * n_periods) & (places < highest * n_fine)
    n_found, original = 0, signal
    spectra_of_others = cache(lambda: [_spectrum_and_floor(other, n_fine) for other in others])
    for _ in range(MOST_TRIED):
        if n_found == n_peaks or not _may_have_line(signal, n_fine, free):
            break
        spectrum, floor = _spectrum_and_floor(signal, n_fine)
        peak = int(np.argmax(np.where(free, spectrum / floor, 0.0)))
        if not free[peak] or spectrum[peak] < LINE * floor[peak]:
            break
        cycles = vertex(spectrum, peak) / n_fine
        # A peak at the low end of the search belongs to something too slow for a line.
        is_new = cycles * n_fine > FINENESS * n_periods - 1 and not any(
            _has_line(*of_other, peak) for of_other in spectra_of_others()
        )
        if is_new and not _is_response(original, others, peak, n_fine):
            yield cycles
            n_found += 1
        free[max(peak - FINENESS, 0) : peak + FINENESS + 1] = False
        signal = _without(signal, cycles)


def vertex(spectrum: np.ndarray, peak: int) -> float:
    """Return the place of a peak between grid points, from the parabola through three of them.

    Parameters
    ----------
    spectrum : ndarray of shape (n,)
        Amplitudes or shares, none negative.
    peak : int
        Grid point of the peak.

    Returns
    -------
    float
        In grid points.
    """
    if not 0 < peak < len(spectrum) - 1:
        return float(peak)
    left, top, right = np.log(np.maximum(spectrum[peak - 1 : peak + 2], TINY))
    bend = left - 2.0 * top + right
    return peak + (0.5 * float((left - right) / bend) if bend < 0.0 else 0.0)


def _without(signal: np.ndarray, cycles: float) -> np.ndarray:
    """Return a signal without its mean and its part at a frequency."""
    phase = 2 * np.pi * cycles * np.arange(len(signal))
    waves = np.column_stack([np.ones(len(signal)), np.sin(phase), np.cos(phase)])
    taper = _taper(len(signal))
    coef = np.linalg.lstsq(waves * taper[:, None], signal * taper, rcond=None)[0]
    return np.asarray(signal - waves @ coef)


def _may_have_line(signal: np.ndarray, n_fine: int, free: np.ndarray) -> bool:
    """Tell from every other frequency, which takes less time, whether there may be a line."""
    spectrum = np.abs(_transform(signal, n_fine // POINTS_PER_HALF_FREQUENCY))
    floor = median_filter(spectrum, SURROUNDINGS)
    return bool(np.any(free[::POINTS_PER_HALF_FREQUENCY] & (spectrum > ROUGHLY * LINE * floor)))


def _spectrum_and_floor(signal: np.ndarray, n_fine: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the amplitude spectrum on the fine grid, and its running median."""
    spectrum = np.abs(_transform(signal, n_fine))
    places = np.arange(len(spectrum))
    coarse = places[::POINTS_PER_HALF_FREQUENCY]
    floor = median_filter(spectrum[coarse], SURROUNDINGS)
    return spectrum, np.maximum(np.interp(places, coarse, floor), TINY)


def _transform(signal: np.ndarray, n_fine: int) -> np.ndarray:
    """Return the complex spectrum of a signal without its mean, tapered and padded with zeros."""
    return np.asarray(fft.rfft((signal - signal.mean()) * _taper(len(signal)), n_fine))


@lru_cache(maxsize=16)
def _taper(n: int) -> np.ndarray:
    return np.hanning(n)


def _is_response(
    signal: np.ndarray, others: Sequence[np.ndarray] | np.ndarray, peak: int, n_fine: int
) -> bool:
    """Tell whether half of a line is a response to inputs, as frequencies around it predict.

    A response there is the spectrum of each input times a quadratic function of the frequency
    (local polynomial method: Schoukens et al., Eur. J. Control 15 (2009),
    DOI 10.3166/ejc.15.260-274).
    """
    near = np.arange(peak % POINTS_PER_HALF_FREQUENCY, n_fine // 2 + 1, POINTS_PER_HALF_FREQUENCY)
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


def _has_line(spectrum: np.ndarray, floor: np.ndarray, peak: int) -> bool:
    """Tell whether a spectrum has a line of its own at a place, not only the skirt of another."""
    top, place = _top(spectrum, peak, FINENESS)
    if top >= LINE * floor[place]:
        return True
    # Between many close lines of equal height the median lies on their skirts, the valleys do not.
    top, _ = _top(spectrum, peak, POINTS_PER_HALF_FREQUENCY)
    reach = POINTS_PER_HALF_FREQUENCY * (SURROUNDINGS // 2)
    valley = np.quantile(
        spectrum[max(peak - reach, 0) : peak + reach + 1 : POINTS_PER_HALF_FREQUENCY], VALLEYS
    )
    return top >= max(COMB * float(valley), MIN_COMB_SHARE * float(spectrum.max()))


def _top(spectrum: np.ndarray, peak: int, reach: int) -> tuple[float, int]:
    """Return the largest value near a place, and where it is; zero if it only rises or falls."""
    start = max(peak - reach, 0)
    near = spectrum[start : peak + reach + 1]
    top = int(np.argmax(near))
    return (float(near[top]) if 0 < top < len(near) - 1 else 0.0), start + top
