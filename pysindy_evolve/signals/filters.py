"""Filters for single signals: low-pass, derivative, integration of accelerations."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy import fft, signal

from .. import checks
from .spectral import Array, SpectralFilter, gain

METHODS = ("fft", "savgol", "central")
MOST_ORDERS = 8  # no measurement holds a ninth derivative
_SHORTEST = 4  # samples; fewer than this cannot tell a parabola from noise at an end


class Motion(NamedTuple):
    """Position, velocity and acceleration in one frequency band, all filtered alike."""

    position: Array
    velocity: Array
    acceleration: Array


def _signal(call: str, parameter: str, values: ArrayLike) -> Array:
    x = checks.columns(call, parameter, values)
    if x.shape[0] < _SHORTEST:
        got = f"{x.shape[0]}"
        advice = "Give a longer record."
        checks.refuse(call, parameter, f"at least {_SHORTEST} samples long", got, advice)
    return x


def lowpass(x: ArrayLike, dt: float, cutoff: float) -> Array:
    """Low-pass columns with zero phase.

    The gain is one half at the cutoff, 0.998 at half of it and 0.002 at 1.5 times of it.

    Parameters
    ----------
    x : ndarray of shape (n_samples,) or (n_samples, n_columns)
        Signals, uniformly sampled.
    dt : float
        Sampling time, units of t.
    cutoff : float
        Cycles per unit of t, in (0, 0.5 / dt).

    Returns
    -------
    ndarray of the shape of x

    Raises
    ------
    ValueError
        If a value is not finite, or dt or the cutoff is out of range.
    TypeError
        If an argument is not made of real numbers.

    Examples
    --------
    >>> import numpy as np
    >>> t = np.arange(1000) * 0.01
    >>> slow, fast = np.sin(2 * t), np.sin(200 * t)
    >>> error = lowpass(slow + fast, 0.01, 5.0) - slow
    >>> bool(np.abs(error[40:-40]).max() < 1e-3)
    True
    """
    columns = _signal("lowpass", "x", x)
    dt = checks.step("lowpass", dt)
    cutoff = checks.cutoff("lowpass", cutoff, dt)
    (result,) = SpectralFilter(columns.shape[0], dt, cutoff)(columns)
    return result.reshape(np.shape(x))


def differentiate(
    x: ArrayLike, dt: float, order: int = 1, method: str = "fft", cutoff: float | None = None
) -> Array:
    """Differentiate columns with respect to time.

    Parameters
    ----------
    x : ndarray of shape (n_samples,) or (n_samples, n_columns)
        Signals, uniformly sampled.
    dt : float
        Sampling time, units of t.
    order : int
        Order of the derivative, 1 to 8.
    method : {"fft", "savgol", "central"}
        Spectral (exact at every frequency; needed with fewer than some 20 samples per period),
        Savitzky-Golay (local polynomials of degree order + 2), or repeated central differences.
    cutoff : float, optional
        Cutoff of a low-pass that is also applied, cycles per unit of t. None filters nothing.

    Returns
    -------
    ndarray of the shape of x
        Units of x per unit of t to the power of order.

    Raises
    ------
    ValueError
        If a value is not finite, or dt, order, method or cutoff is out of range.
    TypeError
        If an argument has the wrong type.

    Notes
    -----
    The first and last two periods of the cutoff are less exact, because the signal beyond the ends
    is not known. `prepare` drops one and a half.

    Examples
    --------
    >>> import numpy as np
    >>> t = np.arange(200) * 0.05
    >>> v = differentiate(np.sin(t), 0.05)
    >>> bool(np.abs(v - np.cos(t))[20:-20].max() < 1e-3)
    True
    """
    columns = _signal("differentiate", "x", x)
    dt = checks.step("differentiate", dt)
    order = checks.count("differentiate", "order", order, MOST_ORDERS)
    method = checks.choice("differentiate", "method", method, METHODS)
    if cutoff is not None:
        cutoff = checks.cutoff("differentiate", cutoff, dt)
    (result,) = derivatives(columns, (order,), dt, cutoff, method)
    return result.reshape(np.shape(x))


def derivatives(
    x: Array, orders: tuple[int, ...], dt: float, cutoff: float | None, method: str
) -> list[Array]:
    """Return derivatives of x (n, k) of the given orders, order 0 the smoothed signal."""
    smooth = SpectralFilter(x.shape[0], dt, cutoff)
    if method == "fft":
        return smooth(x, orders)
    base = x if cutoff is None else smooth(x)[0]
    if method == "savgol":
        return [base if m == 0 else _savgol(base, m, dt, cutoff) for m in orders]
    ladder = [base]
    for _ in range(max(orders)):
        ladder.append(np.gradient(ladder[-1], dt, axis=0))
    return [ladder[order] for order in orders]


def _savgol(x: Array, order: int, dt: float, cutoff: float | None) -> Array:
    """Differentiate a polynomial fitted around each sample."""
    n = x.shape[0]
    degree = order + 2
    half = degree // 2 + 1
    if cutoff is not None:
        # Schafer (2011), doi:10.1109/MSP.2011.941097: half-width for a given -3 dB frequency,
        # here twice the cutoff, so that the polynomial passes what the low-pass passes.
        half = max(half, int(((degree + 1) / (4.0 * cutoff * dt) + 4.6) / 3.2))
    window = min(2 * half + 1, n - (n + 1) % 2)
    return signal.savgol_filter(x, window, min(degree, window - 1), order, dt, axis=0)


def integrate(a: ArrayLike, dt: float, band: tuple[float, float]) -> Motion:
    r"""Integrate accelerations to velocity and position within a frequency band.

    .. math:: \hat v = B(f)\,\hat a / (2 \pi i f), \quad
              \hat q = -B(f)\,\hat a / (2 \pi f)^2, \quad \hat a_B = B(f)\,\hat a

    Below the band an accelerometer shows only drift, which integration would amplify. B removes it
    with zero phase, from the acceleration as well, so that the three stay consistent.

    Parameters
    ----------
    a : ndarray of shape (n_samples,) or (n_samples, n_columns)
        Accelerations, uniformly sampled.
    dt : float
        Sampling time, units of t.
    band : tuple of two floats
        Lowest and highest frequency kept, cycles per unit of t, within (0, 0.5 / dt).
        Choose the lowest at no more than half of the slowest motion of interest.

    Returns
    -------
    Motion
        `position`, `velocity`, `acceleration`, each of the shape of a.

    Raises
    ------
    ValueError
        If a value is not finite or the band is out of range.
    TypeError
        If an argument has the wrong type.

    Notes
    -----
    The first and last three periods of the lowest frequency are contaminated by what happened
    before and after the record: drop them. The gain is 0.63 at the lowest frequency and 1.00
    at twice of it, one half at the highest. Any other column of the same model, such as the
    input, needs the same filter: pass it through and take `acceleration`.

    Examples
    --------
    >>> import numpy as np
    >>> t = np.arange(16000) * 0.005
    >>> q, v, a = integrate(-9.0 * np.sin(3 * t) + 0.1, 0.005, band=(0.1, 20.0))
    >>> bool(np.abs(q - np.sin(3 * t))[6000:-6000].max() < 1e-3)
    True
    """
    columns = _signal("integrate", "a", a)
    dt = checks.step("integrate", dt)
    low, high = _band(band, dt, columns.shape[0])
    n = columns.shape[0]
    # Offset and trend are drift. The rest is extended by reflection and faded out, without a jump.
    detrended = signal.detrend(columns, axis=0)
    pad = min(int(np.ceil(2.0 / (low * dt))), n - 1)
    total = fft.next_fast_len(n + 2 * pad, real=True)
    closed = np.pad(detrended, ((pad, pad), (0, 0)), mode="reflect").T
    fade = np.sin(0.5 * np.pi * np.arange(pad) / pad) ** 2
    closed[:, :pad] *= fade
    closed[:, n + pad :] *= fade[::-1]
    f = fft.rfftfreq(total, dt)
    # A soft lower edge, so that the ends have a short influence; of fourth order, so that the gain
    # divided by f^2 vanishes at zero frequency.
    response = gain(f, high, dt) * -np.expm1(-((f / low) ** 4))
    spectrum = fft.rfft(closed, n=total, axis=1) * response
    omega = 2j * np.pi * np.where(f > 0, f, 1.0)
    rows = slice(pad, pad + n)
    parts = (fft.irfft(spectrum / omega**m, n=total, axis=1)[:, rows].T for m in (2, 1, 0))
    return Motion(*(np.ascontiguousarray(part).reshape(np.shape(a)) for part in parts))


def _band(band: tuple[float, float], dt: float, n: int) -> tuple[float, float]:
    """Return the two frequencies of a band, checked."""
    advice = "Give (lowest, highest) frequency."
    if not isinstance(band, (tuple, list)) or len(band) != 2:
        checks.refuse_type("integrate", "band", "a pair of frequencies", band, advice)
    low, high = (checks.cutoff("integrate", value, dt, "band") for value in band)
    if low >= high:
        checks.refuse("integrate", "band", "(lowest, highest)", repr(tuple(band)), advice)
    if low * n * dt < 2.0:
        got = f"{low:g} with {low * n * dt:.2g} periods in the record"
        advice = "Raise the lowest frequency or record longer."
        checks.refuse("integrate", "band", "such that 2 periods of it fit", got, advice)
    return low, high
