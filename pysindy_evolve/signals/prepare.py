"""Raw records of positions to states and derivatives."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import checks
from .clipping import as_limits, beyond, bridged, widened
from .filters import METHODS, MOST_ORDERS, derivatives
from .noise import auto_cutoff, sensor_noise
from .record import Record, constant_column
from .sampling import uniform
from .spectral import Array, SpectralFilter

# Samples kept per period of the cutoff: sgn and other kinks of the states stay resolved, and
# the low-pass (over at 1.5 times the cutoff) lets nothing alias.
OVERSAMPLING = 8.0
# Automatic decimation keeps this many rows: fewer save no time worth having.
LEAST_ROWS = 500
# Samples per period of the cutoff below which decimation would alias.
LEAST_OVERSAMPLING = 3.0
# Of cutoff and bridges over gaps, each of which follows from the other.
N_ROUNDS = 3
# Periods of the cutoff dropped at each end, where the unknown continuation is felt.
TRIM = 1.5


@dataclass(frozen=True, eq=False)
class Preparation:
    """How a record was made from raw data, resolved to numbers, and ready to be repeated.

    Attributes
    ----------
    t : ndarray of shape (n_raw,)
        Raw time, made uniform.
    y : ndarray of shape (n_raw, n_columns)
        Raw measurements.
    u : ndarray of shape (n_raw, n_inputs) or None
        Raw inputs.
    order : int
        States per column of y.
    method : {"fft", "savgol", "central"}
        How derivatives were taken.
    cutoff : float or None
        Low-pass, cycles per unit of t.
    decimation : int
        Every how many raw samples one was kept.
    trim : int
        Raw samples dropped at each end.
    noise : ndarray of shape (n_columns,)
        Estimated standard deviation of the sensor noise, units of y.
    rows : tuple of two int
        First row and end of the record within all prepared rows (slices of a record).
    limits : ndarray of shape (2, n_columns)
        Lowest and highest reading of the sensors; infinite where no limit shows.
    """

    t: Array
    y: Array
    u: Array | None
    order: int
    method: str
    cutoff: float | None
    decimation: int
    trim: int
    noise: Array
    rows: tuple[int, int]
    limits: Array

    def __repr__(self) -> str:
        band = "cutoff=None" if self.cutoff is None else f"cutoff={self.cutoff:.4g}"
        steps = f"decimation={self.decimation}, trim={self.trim}"
        noise = ", ".join(f"{level:.2g}" for level in self.noise)
        made = f"order={self.order}, method={self.method!r}, {band}"
        return f"Preparation({made}, {steps}, noise=[{noise}])"

    @property
    def dt(self) -> float:
        """Raw sampling time, units of t."""
        return float((self.t[-1] - self.t[0]) / (self.t.size - 1))

    @property
    def settings(self) -> dict[str, Any]:
        """Arguments that prepare another record alike: ``prepare(t, y, u, **settings)``."""
        names = {"order": "order", "cutoff": "cutoff", "decimate": "decimation", "method": "method"}
        settings = {argument: getattr(self, name) for argument, name in names.items()}
        low, high = self.limits.tolist()
        return settings | {"limits": (tuple(low), tuple(high))}

    @cached_property
    def _filter(self) -> SpectralFilter:
        return SpectralFilter(self.t.size, self.dt, self.cutoff, self.decimation, self.trim)

    def _derive(self, raw: Array, orders: tuple[int, ...]) -> list[Array]:
        """Return derivatives of raw columns at the rows of the record."""
        rows = slice(*self.rows)
        if self.method == "fft":
            return [column[rows] for column in self._filter(raw, orders)]
        found = derivatives(raw, orders, self.dt, self.cutoff, self.method)
        return [column[self._filter.kept][rows] for column in found]

    def _raw(self, call: str, parameter: str, values: ArrayLike) -> Array:
        raw = checks.columns(call, parameter, values)
        if raw.shape[0] != self.t.size:
            got = f"{raw.shape[0]} samples"
            advice = "Give the columns at the times preparation.t."
            checks.refuse(call, parameter, f"{self.t.size} samples long", got, advice)
        return raw

    def apply(self, t: ArrayLike, y: ArrayLike, u: ArrayLike | None = None) -> Record:
        """Repeat the identical operation on other data, such as a simulated twin.

        It is linear but for what passes a limit of a sensor, which is clipped first.

        Parameters
        ----------
        t : ndarray of shape (n_raw,)
            Uniform times, of the same length and sampling time as the raw record.
        y : ndarray of shape (n_raw,) or (n_raw, n_columns)
            Measurements.
        u : ndarray of shape (n_raw,) or (n_raw, n_inputs), optional
            Inputs.

        Returns
        -------
        Record

        Raises
        ------
        ValueError
            If lengths or sampling time differ from the raw record, or a value is not finite.
        TypeError
            If an argument is not made of real numbers.
        """
        call = "Preparation.apply"
        times = self.t if t is self.t else checks.times(call, t)
        positions = self._raw(call, "y", y)
        inputs = None if u is None else self._raw(call, "u", u)
        self._raw(call, "t", times)
        step = (times[-1] - times[0]) / (times.size - 1)
        if abs(step / self.dt - 1.0) > 1e-3:
            got = f"steps of {step:g}"
            advice = "Simulate at preparation.t."
            checks.refuse(call, "t", f"sampled every {self.dt:g}", got, advice)
        readings = np.clip(positions, *self.limits)
        whole = bridged(readings, self.limits, self.dt, self.cutoff, self.order)
        levels = self._derive(whole, tuple(range(self.order + 1)))
        return Record(
            t=times[self._filter.kept][slice(*self.rows)],
            x=_interleave(levels[:-1]),
            x_dot=_interleave(levels[1:]),
            u=None if inputs is None else self._derive(inputs, (0,))[0],
            preparation=self,
            seen=self._seen(readings),
        )

    def _seen(self, readings: Array) -> NDArray[np.bool_] | None:
        """Return on which rows each state is that of the machine; None if on all of them."""
        gone = beyond(readings, self.limits)
        if not gone.any():
            return None
        spoiled = widened(gone, self.dt, self.cutoff)[self._filter.kept][slice(*self.rows)]
        return np.asarray(np.repeat(~spoiled, self.order, axis=1))

    def lowpass(self, columns: ArrayLike) -> Array:
        """Low-pass, decimate and trim any columns given at the raw times, as y and u were.

        Parameters
        ----------
        columns : ndarray of shape (n_raw,) or (n_raw, n_columns)

        Returns
        -------
        ndarray of shape (n_samples,) or (n_samples, n_columns)
            Low-passed columns at the times of the record.
        """
        raw = self._raw("Preparation.lowpass", "columns", columns)
        (result,) = self._derive(raw, (0,))
        return result[:, 0] if np.ndim(columns) == 1 else result


def _interleave(levels: list[Array]) -> Array:
    """Order columns by signal, then by derivative: q1, v1, q2, v2."""
    return np.stack(levels, axis=2).reshape(levels[0].shape[0], -1)


def prepare(
    t: ArrayLike,
    y: ArrayLike,
    u: ArrayLike | None = None,
    order: int = 2,
    cutoff: float | str | None = "auto",
    decimate: int | str = "auto",
    method: str = "fft",
    limits: str | Sequence[Any] | None = "auto",
) -> Record:
    r"""Turn a raw record of positions into states and derivatives, all filtered alike.

    Every column, inputs included, passes the same zero-phase low-pass, so a linear equation
    that holds for the raw signals holds for the prepared ones. The automatic cutoff f_c
    minimizes the expected loss of the highest derivative, noise weighing ten times as much
    as lost signal:

    .. math:: \sum_{f > f_c} (2 \pi f)^{2 m} (P(f) - N)
              + 10 \sum_{f \le f_c} (2 \pi f)^{2 m} N,

    where P is the power spectrum of y, N its floor and m the order.

    Parameters
    ----------
    t : ndarray of shape (n_raw,)
        Time, strictly increasing and uniform. Time stamps off by at most half a sampling time
        are interpolated to a uniform grid by cubic splines (off by 1 %: taken as rounded).
    y : ndarray of shape (n_raw,) or (n_raw, n_columns)
        Measured positions, or first-order states.
    u : ndarray of shape (n_raw,) or (n_raw, n_inputs), optional
        Measured inputs.
    order : int
        States per column of y: 1 for y itself, 2 for position and velocity.
    cutoff : "auto", float or None
        Low-pass, cycles per unit of t, below half the sampling rate. None filters nothing.
    decimate : "auto" or int
        Keep every so many samples; automatically eight or more per period of the cutoff.
    method : {"fft", "savgol", "central"}
        How derivatives are taken: spectral, Savitzky-Golay or central differences.
    limits : "auto", None or pair of float or of ndarray of shape (n_columns,)
        Lowest and highest value that the sensors can show, units of y. Where they show them, the
        true value may be anywhere beyond: such rows are bridged before the filter, and marked as
        not `seen`. By default extremes at which fine readings heap; None knows of no limits.

    Returns
    -------
    Record
        Columns of x are y1, its derivatives up to order - 1, y2, ...; `preparation` says how
        it was made. One and a half periods of the cutoff (at most a sixteenth of
        the record) are dropped at each end.

    Raises
    ------
    ValueError
        If a value is not finite, lengths differ, time is irregular, a column of y is
        constant, samples are too few or a setting is out of range.
    TypeError
        If an argument has the wrong type.

    Examples
    --------
    >>> import numpy as np
    >>> t = np.arange(1000) * 0.01
    >>> record = prepare(t, np.sin(2 * t), order=2)
    >>> record.n_states
    2
    >>> bool(np.abs(record.x_dot[:, 1] + 4 * record.x[:, 0]).max() < 0.01)
    True
    """
    times = checks.times("prepare", t)
    raw_y = checks.columns("prepare", "y", y)
    if np.asarray(y).dtype == bool:
        advice = "Give the measured values themselves, not where they exceed a limit."
        checks.refuse_type("prepare", "y", "measured values, not booleans", y, advice)
    raw_u = None if u is None else checks.columns("prepare", "u", u)
    order = checks.count("prepare", "order", order, MOST_ORDERS)
    method = checks.choice("prepare", "method", method, METHODS)
    checks.same_length("prepare", t=times, y=raw_y, u=raw_u)
    _enough(times.size, order)
    grid, (even_y, even_u) = uniform("prepare", times, raw_y, raw_u)
    still = constant_column(raw_y)
    if even_y is None or still is not None:
        got = f"{raw_y[0, still or 0]:g} in all samples of column {still}"
        checks.refuse("prepare", "y", "changing", got, "Drop this column of y.")
    dt = float((grid[-1] - grid[0]) / (grid.size - 1))
    ends = as_limits(limits, even_y)
    resolved, whole = _resolve_cutoff(cutoff, even_y, dt, order, ends)
    trim = 2 if resolved is None else int(np.ceil(TRIM / (resolved * dt)))
    plan = Preparation(
        t=grid,
        y=even_y,
        u=even_u,
        order=order,
        method=method,
        cutoff=resolved,
        decimation=_resolve_decimation(decimate, resolved, dt, grid.size),
        trim=min(trim, grid.size // 16),
        noise=sensor_noise(whole, dt, resolved),
        rows=(0, grid.size),
        limits=ends,
    )
    return plan.apply(plan.t, plan.y, plan.u)


def _enough(n: int, order: int) -> None:
    """Raise where a record is too short to see a derivative of this order."""
    least = 16 + 4 * order
    if n < least:
        advice = "Record longer or sample faster."
        checks.refuse("prepare", "t", f"at least {least} samples long", f"{n}", advice)


def _resolve_cutoff(
    cutoff: Any, y: Array, dt: float, order: int, limits: Array
) -> tuple[float | None, Array]:
    """Return the cutoff in cycles per unit of t, and the readings without gaps."""
    if isinstance(cutoff, str):
        if cutoff != "auto":
            advice = 'Write "auto" to take it from the noise floor.'
            checks.refuse("prepare", "cutoff", '"auto", a number or None', repr(cutoff), advice)
        return _auto_cutoff(y, dt, order, limits)
    resolved = None if cutoff is None else checks.cutoff("prepare", cutoff, dt)
    return resolved, bridged(y, limits, dt, resolved, order)


def _auto_cutoff(y: Array, dt: float, order: int, limits: Array) -> tuple[float, Array]:
    """Return cutoff and bridged readings, which depend on each other."""
    cutoff, whole = auto_cutoff(y, dt, order), y
    if not beyond(y, limits).any():
        return cutoff, whole
    for _ in range(N_ROUNDS):
        whole = bridged(y, limits, dt, cutoff, order)
        cutoff = auto_cutoff(whole, dt, order)
    return cutoff, whole


def _resolve_decimation(decimate: Any, cutoff: float | None, dt: float, n: int) -> int:
    """Return every how many samples one is kept."""
    per_period = 0.0 if cutoff is None else 1.0 / (cutoff * dt)
    if isinstance(decimate, str):
        if decimate != "auto":
            advice = 'Write "auto" to take it from the cutoff.'
            checks.refuse("prepare", "decimate", '"auto" or an integer', repr(decimate), advice)
        return max(1, min(int(per_period / OVERSAMPLING), n // LEAST_ROWS))
    most = max(1, int(per_period / LEAST_OVERSAMPLING))
    factor = checks.count("prepare", "decimate", decimate)
    if factor > most:
        advice = "More would alias: lower the cutoff first."
        checks.refuse("prepare", "decimate", f"at most {most} here", f"{factor}", advice)
    return factor
