r"""Zero-phase low-pass and derivatives by FFT, one fixed linear operation on every column.

The response to a frequency f is

.. math:: H(f) = \tfrac12 \operatorname{erfc}\frac{|f| - f_c}{w},
   \qquad H_m(f) = (2 \pi i f)^m H(f),

with cutoff f_c (gain one half) and edge width w. Its kernel decays like
:math:`\exp(-(\pi w t)^2)`, so samples farther away than 1 / w have no influence: the ends of a
record spoil a known, short stretch, and steps ring for only two or three periods of the cutoff.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy import fft, special

Array = NDArray[np.float64]

# Edge width over cutoff: sharp enough to keep the band flat, soft enough that the kernel ends after
# four periods of the cutoff.
EDGE = 0.25
# Length, in fit spans, after which the parabola at an end levels off: 1.5 periods of the cutoff.
BOUND_IN_SPANS = 1.0


def edge_width(cutoff: float, dt: float) -> float:
    """Return the width w of the filter's edge, narrower near the Nyquist frequency."""
    return min(EDGE * cutoff, 0.5 * (0.5 / dt - cutoff))


def gain(frequency: Array, cutoff: float | None, dt: float) -> Array:
    """Return H(f) for frequencies in cycles per unit of t; all ones without a cutoff."""
    if cutoff is None:
        return np.ones_like(frequency)
    edge = (np.abs(frequency) - cutoff) / edge_width(cutoff, dt)
    return 0.5 * special.erfc(edge)


@dataclass(frozen=True)
class Extension:
    """Smooth extension of a record of n samples beyond both ends, which makes it periodic.

    Each end is extended by point reflection about the parabola fitted there,
    y(-k) = 2 (p0 + p2 k^2) - y(k), which keeps value, slope and curvature, and fades into the
    straight line between the two ends.

    Parameters
    ----------
    n : int
        Samples of the record.
    reach : int
        Samples over which the filter's kernel acts.
    span : int
        Samples at each end that the parabola is fitted to.
    """

    n: int
    reach: int
    span: int

    @classmethod
    def for_cutoff(cls, n: int, cutoff: float | None, dt: float) -> Extension:
        """Return the extension that a low-pass at this cutoff needs."""
        if cutoff is None:
            return cls(n, min(32, n - 1), min(5, n))
        reach = int(np.ceil(1.0 / (edge_width(cutoff, dt) * dt)))
        # 1.5 periods of the cutoff average the noise, and what the filter passes is no more than a
        # cubic over them.
        span = max(7, int(np.ceil(1.5 / (cutoff * dt))))
        return cls(n, min(reach, n - 1), min(span, n))

    @property
    def pad(self) -> int:
        """Samples added at each end."""
        return min(2 * self.reach, self.n - 1)

    @property
    def bound(self) -> float:
        """Samples after which the parabola levels off, so that a fast signal stays bounded."""
        return BOUND_IN_SPANS * self.span

    @cached_property
    def _fit(self) -> Array:
        """Rows that give p0 and p2 of a cubic fitted to the first `span` samples."""
        k = np.arange(self.span) / max(self.span - 1, 1)
        degree = min(3, self.span - 1)
        rows = np.linalg.pinv(np.vander(k, degree + 1, increasing=True))
        curvature = rows[2] if degree >= 2 else np.zeros(self.span)
        return np.stack([rows[0], curvature / max(self.span - 1, 1) ** 2])

    @cached_property
    def fade(self) -> Array:
        """One over the reach, then a half cosine down to zero at the end of the padding."""
        k = np.arange(1, self.pad + 1)
        fall = np.clip((k - self.pad / 2) / (self.pad / 2), 0.0, 1.0)
        return np.asarray(0.5 + 0.5 * np.cos(np.pi * fall))

    def __call__(self, y: Array, left: int, total: int) -> tuple[Array, Array]:
        """Return the extended, periodic columns, and the straight lines subtracted from them.

        Parameters
        ----------
        y : ndarray of shape (n_columns, n)
        left : int
            Samples in front of the record: zeros and the extension; at least `pad`.
        total : int
            Length of the result.

        Returns
        -------
        closed : ndarray of shape (n_columns, total)
        line : ndarray of shape (n_columns, 2)
            Value at the first sample and slope per sample.
        """
        start, start_curve = self._fit @ y[:, : self.span].T
        end, end_curve = self._fit @ y[:, ::-1][:, : self.span].T
        slope = (end - start) / (self.n - 1)
        closed = np.zeros((y.shape[0], total))
        body = closed[:, left : left + self.n]
        body[:] = y - (start[:, None] + slope[:, None] * np.arange(self.n))
        k = np.arange(1, self.pad + 1)
        bend = 2.0 * self.bound**2 * -np.expm1(-((k / self.bound) ** 2))
        before = start_curve[:, None] * bend - body[:, 1 : self.pad + 1]
        after = end_curve[:, None] * bend - body[:, ::-1][:, 1 : self.pad + 1]
        closed[:, left - self.pad : left] = (before * self.fade)[:, ::-1]
        stop = left + self.n
        closed[:, stop : stop + self.pad] = after * self.fade
        return closed, np.stack([start, slope], axis=1)


@dataclass(frozen=True)
class SpectralFilter:
    """Low-pass, derivatives, decimation and trimming in one FFT, the same for every column.

    Parameters
    ----------
    n : int
        Samples of the raw record.
    dt : float
        Sampling time, units of t.
    cutoff : float or None
        Cycles per unit of t; None keeps every frequency.
    decimation : int
        Every `decimation`-th sample is kept.
    trim : int
        Raw samples dropped at each end.
    """

    n: int
    dt: float
    cutoff: float | None
    decimation: int = 1
    trim: int = 0
    _responses: dict[int, Array] = field(default_factory=dict, repr=False, compare=False)

    @cached_property
    def _extension(self) -> Extension:
        return Extension.for_cutoff(self.n, self.cutoff, self.dt)

    @cached_property
    def _left(self) -> int:
        """Samples in front of the record, so many that the first kept one is on the coarse grid."""
        pad = self._extension.pad
        return pad + (-(pad + self.trim)) % self.decimation

    @cached_property
    def _length(self) -> int:
        needed = self._left + self.n + self._extension.pad
        return self.decimation * int(fft.next_fast_len(-(-needed // self.decimation), real=True))

    @cached_property
    def kept(self) -> NDArray[np.intp]:
        """Indices of the raw samples that are kept."""
        return np.arange(self.trim, self.n - self.trim, self.decimation)

    def _response(self, order: int) -> Array:
        if order not in self._responses:
            coarse = self._length // self.decimation
            f = fft.rfftfreq(coarse, self.dt * self.decimation)
            response = (2j * np.pi * f) ** order * gain(f, self.cutoff, self.dt)
            if coarse % 2 == 0 and order % 2:
                response[-1] = 0.0  # an odd derivative has no Nyquist component
            self._responses[order] = response / self.decimation
        return self._responses[order]

    def __call__(self, columns: Array, orders: tuple[int, ...] = (0,)) -> list[Array]:
        """Return the low-passed derivatives of the given orders at the kept samples.

        Parameters
        ----------
        columns : ndarray of shape (n, n_columns)
        orders : tuple of int
            Orders of differentiation; 0 is the low-pass alone.

        Returns
        -------
        list of ndarray of shape (n_kept, n_columns)
        """
        closed, line = self._extension(columns.T, self._left, self._length)
        coarse = self._length // self.decimation
        spectrum = fft.rfft(closed, axis=1)[:, : coarse // 2 + 1]
        first = (self._left + self.trim) // self.decimation
        results = []
        for order in orders:
            full = fft.irfft(spectrum * self._response(order), n=coarse, axis=1)
            part = full[:, first : first + self.kept.size].T
            if order == 0:
                part = part + line[:, 0] + self.kept[:, None] * line[:, 1]
            elif order == 1:
                part = part + line[:, 1] / self.dt
            results.append(np.ascontiguousarray(part))
        return results
