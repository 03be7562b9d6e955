r"""Smooth compact windows along the rows: the weak form.

Both sides of an equation x_dot = theta(x) are multiplied by a window
:math:`\varphi(s) = (1 - s^2)^p, |s| < 1` and summed. This is a linear map on the rows, so an
equation that held before holds after it; it averages noise and leaves fewer rows. It is applied to
terms after they are evaluated: a smoothed sgn(v) is not the sgn of a smoothed v.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy import fft

from .. import checks
from .noise import auto_cutoff
from .record import Record
from .spectral import Array

# A window (1 - s^2)^4 of full width W halves a sine of frequency 1.24 / W.
HALF_GAIN = 1.24
# Width in periods of the cutoff of the states. The gain is then one half at an eighth of the
# cutoff. The octaves above it, where the spectrum sinks into noise, hardly tell terms apart.
PERIODS = 10.0
# The band below half gain must hold at least this share of the derivative's power ...
MIN_POWER_SHARE = 0.9
# ... and this multiple of the frequency that halves the power: the nonlinearity of a single slow
# oscillation shows in its harmonics.
HARMONICS = 2.0


@dataclass(frozen=True)
class Windows:
    """Overlapping windows (1 - s^2)^power along the samples.

    Parameters
    ----------
    width : int
        Full width in samples; 1 leaves the rows as they are.
    stride : int
        Samples from one window to the next.
    power : int
        Smoothness: power - 1 derivatives vanish at the edges.

    Raises
    ------
    ValueError
        If a field is below 1.
    TypeError
        If a field is no integer.
    """

    width: int
    stride: int = 1
    power: int = 4

    def __post_init__(self) -> None:
        for name in ("width", "stride", "power"):
            checks.count("Windows", name, getattr(self, name))

    @cached_property
    def s(self) -> Array:
        """Places of the samples in the window, from -1 to 1, edges excluded."""
        return np.asarray((np.arange(self.width) + 0.5) * (2.0 / self.width) - 1.0)

    @cached_property
    def weights(self) -> Array:
        """Weights of the samples, which sum to one."""
        phi = (1.0 - self.s**2) ** self.power
        return np.asarray(phi / phi.sum())

    @cached_property
    def derivative_weights(self) -> Array:
        """Weights that turn x into the windowed derivative, per sample; exact on a line."""
        slope = self.s * (1.0 - self.s**2) ** (self.power - 1)
        return np.asarray(slope / (slope @ np.arange(self.width)))

    def count(self, n: int) -> int:
        """Return how many windows fit into n samples."""
        return max(0, (n - self.width) // self.stride + 1)

    def centers(self, n: int) -> Array:
        """Return the middle of each window, in samples (half-integers for an even width)."""
        first = 0.5 * (self.width - 1)
        return np.asarray(first + self.stride * np.arange(self.count(n)))


def project(columns: ArrayLike, windows: Windows, lengths: Sequence[int] | None = None) -> Array:
    """Average columns over windows.

    Parameters
    ----------
    columns : ndarray of shape (n_samples,) or (n_samples, n_columns)
        Target or evaluated terms, uniformly sampled.
    windows : Windows
        From `choose_windows`, or your own.
    lengths : sequence of int, optional
        Samples of each trajectory, where several are stacked; no window crosses a border.

    Returns
    -------
    ndarray of shape (n_windows,) or (n_windows, n_columns)
        Units of the columns.

    Raises
    ------
    ValueError
        If lengths do not add up, or no window fits into a trajectory.
    TypeError
        If an argument has the wrong type.

    Notes
    -----
    The cost is n_samples * n_columns * width / stride.

    Examples
    --------
    >>> import numpy as np
    >>> project(np.arange(10.0), Windows(width=4, stride=3))
    array([1.5, 4.5, 7.5])
    """
    return _slide("project", columns, windows, lengths, 0)


def project_derivative(
    columns: ArrayLike, windows: Windows, dt: float, lengths: Sequence[int] | None = None
) -> Array:
    r"""Average the time derivative of columns over windows, without differentiating them.

    Summation by parts moves the derivative to the window, which is known exactly:
    :math:`\int \varphi \dot x = -\int \dot\varphi x`.

    Parameters
    ----------
    columns : ndarray of shape (n_samples,) or (n_samples, n_columns)
        States, uniformly sampled.
    windows : Windows
        At least two samples wide.
    dt : float
        Sampling time, units of t.
    lengths : sequence of int, optional
        Samples of each trajectory, where several are stacked.

    Returns
    -------
    ndarray of shape (n_windows,) or (n_windows, n_columns)
        Units of the columns per unit of t.

    Raises
    ------
    ValueError
        If lengths do not add up, or no window fits into a trajectory.
    TypeError
        If an argument has the wrong type.

    Examples
    --------
    >>> import numpy as np
    >>> project_derivative(3 * np.arange(10) * 0.1, Windows(width=4, stride=3), dt=0.1)
    array([3., 3., 3.])
    """
    dt = checks.step("project_derivative", dt)
    return _slide("project_derivative", columns, windows, lengths, 1) / dt


def _slide(
    call: str, columns: ArrayLike, windows: Any, lengths: Sequence[int] | None, order: int
) -> Array:
    """Apply the windows (order 0) or their derivative (order 1) to each trajectory."""
    # No upper limit on values: a term such as the cube of a large state is valid.
    rows = checks.columns(call, "columns", columns, most=np.inf)
    if not isinstance(windows, Windows):
        advice = "Take them from choose_windows."
        checks.refuse_type(call, "windows", "Windows", windows, advice)
    sizes = [rows.shape[0]] if lengths is None else [int(length) for length in lengths]
    if sum(sizes) != rows.shape[0] or min(sizes, default=0) < 0:
        got = f"{sizes} for {rows.shape[0]} samples"
        checks.refuse(call, "lengths", "the samples of each trajectory", got, "Check the sum.")
    if min(sizes, default=0) < windows.width:
        got = f"{windows.width} samples for a trajectory of {min(sizes, default=0)}"
        checks.refuse(call, "windows", "narrower than a trajectory", got, "Take narrower ones.")
    if order and windows.width < 2:
        checks.refuse(call, "windows", "2 samples wide or more", "1", "Take wider windows.")
    weights = windows.derivative_weights if order else windows.weights
    starts = np.cumsum([0, *sizes[:-1]])
    parts = [_weigh(rows[a : a + n], windows, weights) for a, n in zip(starts, sizes, strict=True)]
    result = parts[0] if len(parts) == 1 else np.concatenate(parts)
    return result[:, 0] if np.ndim(columns) == 1 else result


def _weigh(rows: Array, windows: Windows, weights: Array) -> Array:
    """Sum weighted rows; one pass over the result per sample of the window."""
    n_windows = windows.count(rows.shape[0])
    span = (n_windows - 1) * windows.stride + 1
    result = np.zeros((n_windows, rows.shape[1]))
    weighted = np.empty_like(result)
    for offset, weight in enumerate(weights):
        np.multiply(rows[offset : offset + span : windows.stride], weight, out=weighted)
        result += weighted
    return result


def choose_windows(records: Record | Sequence[Record]) -> Windows:
    """Choose windows for records of the same sampling time.

    They are as wide as ten periods of the cutoff of the states, so that what lies above the
    cutoff is averaged away, but so narrow that nine tenths of the power of every derivative,
    and twice its median frequency, lie below their half gain. Four windows overlap everywhere.

    Parameters
    ----------
    records : Record or sequence of Record
        What the windows are for; cutoff from the preparation, or from the noise floor of
        x_dot where the user made the record.

    Returns
    -------
    Windows

    Raises
    ------
    ValueError
        If there is no record.
    TypeError
        If something is not a Record.
    """
    several = [records] if isinstance(records, Record) else list(records)
    call, advice = "choose_windows", "Give what prepare returned."
    for record in several:
        if not isinstance(record, Record):
            checks.refuse_type(call, "records", "a Record or several", record, advice)
    if not several:
        checks.refuse(call, "records", "one record or more", "none", advice)
    width = min(_width(record) for record in several)
    shortest = min(record.n_samples for record in several)
    width = max(1, min(width, shortest // 8))
    width = 1 if width < 4 else width
    return Windows(width=width, stride=max(1, width // 4))


def _width(record: Record) -> int:
    """Return the widest reasonable window of one record, in samples."""
    dt = record.dt
    if record.n_samples < 16:
        return 1
    moving = record.x_dot[:, np.ptp(record.x_dot, axis=0) > 0]
    if moving.shape[1] == 0:
        return 1
    moving = moving / np.ptp(moving, axis=0)
    made = record.preparation
    cutoff = made.cutoff if made is not None else auto_cutoff(moving, dt, 0)
    # Cosine transform: no taper, so what happens at the ends counts as well.
    power = fft.dct(moving - moving.mean(axis=0), axis=0)[1:] ** 2
    share = np.cumsum(power, axis=0) / np.sum(power, axis=0)
    reached = np.maximum(_bin(share, MIN_POWER_SHARE), HARMONICS * _bin(share, 0.5))
    band = float(np.max(reached)) / (2.0 * record.n_samples * dt)
    periods = PERIODS / cutoff if cutoff is not None else np.inf
    return int(min(periods, HALF_GAIN / band) / dt)


def _bin(share: Array, level: float) -> Array:
    """Return the 1-based bin at which each cumulated share reaches the level."""
    return np.asarray(1.0 + np.argmax(share >= level, axis=0))
