"""Twins: records of a machine that the declared model describes in full.

Whatever a search finds in a twin, it finds where nothing is missing. A twin follows the model with
the measured input, carries the noise of the sensor through the same preparation, and has the part
of the residual that this noise does not explain, multiplied by a slow random signal: as strong and
as colored as measured, wherever it was, but a function of nothing.

References
----------
Shao, JASA 105 (2010), DOI 10.1198/jasa.2009.tm08744, the dependent wild bootstrap.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import gaussian_filter1d

from ..equations import Equations
from ..signals import Record
from ..simulation import simulate

__all__ = ["TwinMaker", "shuffle_signs"]

FAITHFUL = 0.5  # a simulation that strays further, in standard deviations, is no twin


@dataclass(frozen=True, eq=False)
class TwinMaker:
    """Makes twins of records, one for each random generator."""

    equations: Equations
    records: tuple[Record, ...]
    simulated: tuple[np.ndarray | None, ...]
    residuals: tuple[np.ndarray, ...]

    @classmethod
    def of(cls, equations: Equations, richer: Equations, records: Sequence[Record]) -> TwinMaker:
        """Simulate the model once along each record.

        Parameters
        ----------
        equations : Equations
            The model in which nothing is missing, fitted.
        richer : Equations
            The model with the effect that is on trial. What it leaves has the color of the
            disturbances; what the poorer model leaves may have the color of the effect.
        records : sequence of Record
            What was measured.

        Returns
        -------
        TwinMaker
        """
        residuals = tuple(r.x_dot - richer.evaluate(r.x, r.u, r.t) for r in records)
        simulated = tuple(_follow(equations, record) for record in records)
        return cls(equations, tuple(records), simulated, residuals)

    def make(self, rng: np.random.Generator) -> list[Record]:
        """Return one twin of each record."""
        parts = zip(self.records, self.simulated, self.residuals, strict=True)
        return [self._twin(record, path, residual, rng) for record, path, residual in parts]

    def _twin(
        self,
        record: Record,
        path: np.ndarray | None,
        residual: np.ndarray,
        rng: np.random.Generator,
    ) -> Record:
        twin, explained = record, np.zeros_like(residual)
        if path is not None and record.preparation is not None:
            made = record.preparation
            noisy = path + made.noise * rng.standard_normal(path.shape)
            twin = made.apply(made.t, noisy, made.u)
            explained = twin.x_dot - self.equations.evaluate(twin.x, twin.u, twin.t)
        left = np.maximum(residual.var(axis=0) - explained.var(axis=0), 0.0)
        share = np.sqrt(left / np.maximum(residual.var(axis=0), 1e-300))
        rates = self.equations.evaluate(twin.x, twin.u, twin.t)
        disturbed = rates + explained + share * shuffle_signs(residual, rng)
        return replace(twin, x_dot=disturbed)


def shuffle_signs(columns: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Multiply columns by a slow random signal: the dependent wild bootstrap.

    What is strong at some time stays strong there, and what is colored stays so over the memory
    of the columns, but nothing is a function of the states any more.

    Parameters
    ----------
    columns : ndarray of shape (n_samples, n_columns)
        Residuals. All are multiplied by the same signal, so what they share stays shared.
    rng : numpy.random.Generator
        Draws the signal.

    Returns
    -------
    ndarray of shape (n_samples, n_columns)
    """
    n = len(columns)
    slow = gaussian_filter1d(rng.standard_normal(n), _memory(columns), mode="wrap")
    return columns * (slow / max(float(slow.std()), 1e-300))[:, None]


def _memory(columns: np.ndarray) -> float:
    """Return twice the lag, in samples, at which the autocorrelation has fallen to a tenth."""
    n = len(columns)
    spectrum = np.fft.rfft(columns - columns.mean(axis=0), 2 * n, axis=0)
    covariance = np.fft.irfft(np.abs(spectrum) ** 2, axis=0)[:n]
    correlation = np.max(covariance / np.maximum(covariance[0], 1e-300), axis=1)
    lag = int(np.argmax(correlation < 0.1)) or n
    return float(np.clip(2 * lag, 2, max(2, n // 40)))


def _follow(equations: Equations, record: Record) -> np.ndarray | None:
    """Simulate the measured columns at the raw times; None if the model strays too far."""
    made = record.preparation
    if made is None:
        return None
    first = int(np.argmin(np.abs(made.t - record.t[0])))
    times, raw_u = made.t, made.u
    path = np.array(made.y, dtype=float)
    ahead = simulate(
        equations,
        record.x[0],
        times[first:],
        None if raw_u is None else raw_u[first:],
        tolerance=1e-5,
        on_divergence="nan",
    )
    positions = ahead[:, :: made.order]
    # Rows before the record, which the preparation trims, only need to join without a jump.
    path[first:] = positions
    path[:first] += positions[0] - made.y[first]
    stray = np.sqrt(np.mean((positions - made.y[first:]) ** 2, axis=0))
    return path if np.all(stray < FAITHFUL * made.y.std(axis=0)) else None
