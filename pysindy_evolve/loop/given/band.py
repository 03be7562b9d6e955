"""Runs and records seen through the same low-pass.

The low-pass of a record removes harmonics of the motion that the run of a model still has. The
difference is a function of the state, and looks like physics. So a run passes the same low-pass
before it is compared with the record. Its inputs pass a wider one; otherwise the response to them
would be low-passed twice.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np

from ...signals import Record
from ...signals.spectral import SpectralFilter

MAX_CUTOFF_RATIO = 2.0  # cutoff of the inputs of runs, in cutoffs of the states ...
MIN_NYQUIST_RATIO = 1.5  # ... and at most half the sampling rate over this
MIN_SAMPLES = 4  # samples; no parabola continues the ends of a shorter piece


@dataclass(frozen=True, eq=False)
class Band:
    """The low-passes of records, for runs over pieces of them.

    Attributes
    ----------
    records : tuple of Record
        The records.
    places : tuple of (int, int)
        Record and first row of each piece.
    length : int
        Rows of each piece.
    """

    records: tuple[Record, ...]
    places: tuple[tuple[int, int], ...]
    length: int

    def shown(self, x: np.ndarray) -> np.ndarray:
        """Return runs over the pieces, (n_pieces, n, n_states), after the low-passes.

        The record is known before and after a piece, a run is not. So the record is low-passed as a
        whole, and of a run only its difference from the record.
        """
        found = np.array(x)
        for k, record in enumerate(self.records):
            in_record = np.flatnonzero([place[0] == k for place in self.places])
            if len(in_record) and self.length >= MIN_SAMPLES and record.cutoff is not None:
                before, after = self._cut(k, record.x), self._cut(k, self._passed[k])
                columns = np.moveaxis(x[in_record] - before, 0, 1)  # (n, n_pieces, n_states)
                passed = _low_passed(record, columns.reshape(self.length, -1))
                found[in_record] = after + np.moveaxis(passed.reshape(columns.shape), 1, 0)
        return found

    def _cut(self, k: int, x: np.ndarray) -> np.ndarray:
        """Return the pieces of one record."""
        return np.stack([x[row : row + self.length] for i, row in self.places if i == k])

    @cached_property
    def _passed(self) -> list[np.ndarray]:
        """States of the records, low-passed once more."""
        return [_low_passed(record, record.x) for record in self.records]


def _low_passed(record: Record, x: np.ndarray) -> np.ndarray:
    """Return columns (n, n_columns) after the low-pass of a record; NaN where a run diverges."""
    if record.cutoff is None:
        return x
    with np.errstate(over="ignore", invalid="ignore"):
        return _low_pass(len(x), record.dt, record.cutoff)(x)[0]


@lru_cache(maxsize=32)
def _low_pass(n: int, dt: float, cutoff: float) -> SpectralFilter:
    return SpectralFilter(n, dt, cutoff)


def driven(record: Record) -> Record:
    """Return a record with inputs for runs that are low-passed afterwards."""
    made = record.preparation
    if made is None or made.cutoff is None or made.u is None:
        return record
    if made.decimation == 1:
        return replace(record, u=made.u[made.trim : made.t.size - made.trim][slice(*made.rows)])
    wide = float(
        np.clip(0.5 / (MIN_NYQUIST_RATIO * record.dt), made.cutoff, MAX_CUTOFF_RATIO * made.cutoff)
    )
    return replace(record, u=replace(made, cutoff=wide).lowpass(made.u))


def straightened(record: Record) -> Record:
    """Return a record whose inputs, interpolated linearly, act as the smooth ones do.

    Linear interpolation makes a sine smaller by the share (omega dt)^2 / 12.
    """
    if record.preparation is None or record.u is None or len(record) < MIN_SAMPLES:
        return record
    u = record.u.copy()
    u[1:-1] -= np.diff(record.u, n=2, axis=0) / 12.0
    return replace(record, u=u)
