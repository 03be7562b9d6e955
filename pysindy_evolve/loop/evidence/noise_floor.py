"""The residual that sensor noise alone leaves, as power in bands of frequency."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...checks import TINY
from ...equations import Equations
from ...signals import Record
from ..fitting.residual import residual_on
from ..given.design import Design
from ..given.input_errors import input_error
from ..given.segments import Segments
from ..given.sensor import as_observed
from .spectral import spectral_rows

N_DRAWS = 4  # draws of the noise
# Power of a residual in a band over that of noise alone; less may be chance.
MIN_POWER_OVER_NOISE = 1.5
N_BANDS, FEWEST = 16, 4  # bands, and frequencies in each


@dataclass(frozen=True, eq=False)
class NoiseFloor:
    """The power of the residual that noise alone leaves, (n_bands, n_open)."""

    design: Design
    part: Segments
    power: np.ndarray

    @classmethod
    def of(
        cls, equations: Equations, design: Design, part: Segments, rng: np.random.Generator
    ) -> NoiseFloor | None:
        """Add the sensor noise of states and inputs to the records once more.

        Parameters
        ----------
        equations : Equations
            A model of the machine.
        design : Design
            Says which equations are looked at.
        part : Segments
            Pieces of the training records.
        rng : numpy.random.Generator
            Draws the noise.

        Returns
        -------
        NoiseFloor or None
            None if the sensors of a record are not known.
        """
        powers = []
        for child in rng.spawn(N_DRAWS):
            drawn = [noise_alone(equations, record, child) for record in part.records]
            known = [columns for columns in drawn if columns is not None]
            if len(known) < len(drawn):
                return None
            powers.append(_power(known, design, part))
        return cls(design, part, np.mean(powers, axis=0))

    def excess(self, equations: Equations) -> float:
        """Return the largest ratio of a model's residual power to that of noise, over all bands."""
        residuals = [residual_on(equations, record) for record in self.part.records]
        power = _power(residuals, self.design, self.part)
        return float(np.max(power / np.maximum(self.power, TINY)))


def noise_alone(
    equations: Equations, record: Record, rng: np.random.Generator
) -> np.ndarray | None:
    """Return by how much sensor noise changes the residual, (n_samples, n_states).

    Parameters
    ----------
    equations : Equations
        A model of the machine.
    record : Record
        What was measured.
    rng : numpy.random.Generator
        Draws the noise.

    Returns
    -------
    ndarray of shape (n_samples, n_states) or None
        Units of x_dot; None if the sensors are not known, as the record was not made from raw data.
    """
    made = record.preparation
    if made is None:
        return None
    noisier = made.apply(made.t, made.y + made.noise * rng.standard_normal(made.y.shape))
    error = input_error(record, rng)
    u = record.u if error is None or record.u is None else record.u + error
    rates = equations.evaluate(noisier.x, u, noisier.t)
    return as_observed(record, noisier.x_dot - rates) - residual_on(equations, record)


def _power(columns: Sequence[np.ndarray], design: Design, part: Segments) -> np.ndarray:
    """Return the power of residuals in bands of frequency, (n_bands, n_open)."""
    rows = spectral_rows(part, (part.cut(columns) * part.weight)[:, :, list(design.open_states)])
    power = np.mean(np.abs(rows) ** 2, axis=0)
    n_bands = max(1, min(N_BANDS, len(power) // FEWEST))
    return np.array([band.mean(axis=0) for band in np.array_split(power, n_bands)])
