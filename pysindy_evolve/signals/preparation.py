"""How a record was prepared from raw data, to be repeated for other data."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import checks
from .clipping import beyond, bridged, widened
from .filters import derivatives
from .record import Record
from .sampling import mean_step
from .spectral import Array, SpectralFilter


@dataclass(frozen=True, eq=False)
class Preparation:
    """How a record was prepared from raw data, with all settings as numbers.

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
        One of so many raw samples was kept.
    trim : int
        Raw samples dropped at each end.
    noise : ndarray of shape (n_columns,)
        Estimated standard deviation of the sensor noise, units of y.
    rows : tuple of two int
        First row and end of the record within all prepared rows (slices of a record).
    limits : ndarray of shape (2, n_columns)
        Lowest and highest reading of the sensors; infinite where no limit shows.
    steps : ndarray of shape (n_raw, n_inputs) or None
        Raw inputs as they were recorded, if `u` holds the effective values of held inputs.
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
    steps: Array | None = None

    def __repr__(self) -> str:
        band = "cutoff=None" if self.cutoff is None else f"cutoff={self.cutoff:.4g}"
        steps = f"decimation={self.decimation}, trim={self.trim}"
        noise = ", ".join(f"{level:.2g}" for level in self.noise)
        made = f"order={self.order}, method={self.method!r}, {band}"
        return f"Preparation({made}, {steps}, noise=[{noise}])"

    @property
    def dt(self) -> float:
        """Raw sampling time, units of t."""
        return mean_step(self.t)

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

        It is linear, except that values beyond a limit of a sensor are clipped first.

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
        step = mean_step(times)
        if abs(step / self.dt - 1.0) > 1e-3:
            got = f"steps of {step:g}"
            advice = "Simulate at preparation.t."
            checks.refuse(call, "t", f"sampled every {self.dt:g}", got, advice)
        readings = np.clip(positions, *self.limits)
        filled = bridged(readings, self.limits, self.dt, self.cutoff, self.order)
        levels = self._derive(filled, tuple(range(self.order + 1)))
        return Record(
            t=times[self._filter.kept][slice(*self.rows)],
            x=_interleave(levels[:-1]),
            x_dot=_interleave(levels[1:]),
            u=None if inputs is None else self._derive(inputs, (0,))[0],
            preparation=self,
            seen=self._seen(readings),
        )

    def _seen(self, readings: Array) -> NDArray[np.bool_] | None:
        """Return the rows on which the sensor of each state shows it; None if all do."""
        at_limit = beyond(readings, self.limits)
        if not at_limit.any():
            return None
        spoiled = widened(at_limit, self.dt, self.cutoff)[self._filter.kept][slice(*self.rows)]
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

        Raises
        ------
        ValueError
            If there are not as many rows as raw times, or a value is not finite.
        TypeError
            If `columns` is not made of real numbers.
        """
        raw = self._raw("Preparation.lowpass", "columns", columns)
        (result,) = self._derive(raw, (0,))
        return result[:, 0] if np.ndim(columns) == 1 else result


def _interleave(levels: list[Array]) -> Array:
    """Order columns by signal, then by derivative: q1, v1, q2, v2."""
    return np.stack(levels, axis=2).reshape(levels[0].shape[0], -1)
