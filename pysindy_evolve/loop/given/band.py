"""Runs and records seen through the same low-pass.

The motion of a machine has harmonics that a low-pass has taken off its record, and that the run of
a model still has. What the two differ by is a function of the state, and looks like physics. So a
record is held against what the same low-pass leaves of a run, and the run is driven by inputs that
passed a wider one, or what it answers to them would be low-passed twice.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np

from ...signals import Record
from ...signals.spectral import SpectralFilter

__all__ = ["Band", "driven", "straightened"]

WIDER = 2.0  # cutoff of the inputs of runs, in cutoffs of the states ...
OVER = 1.5  # ... and at most half the sampling rate over this
SHORTEST = 4  # samples; no parabola continues what is shorter


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
        """Return what the low-passes leave of runs over the pieces, (n_pieces, n, n_states).

        What comes before and after a piece, the record knows and a run does not. So the record is
        low-passed as a whole, and of a run no more than its difference from the record.
        """
        found = np.array(x)
        for k, record in enumerate(self.records):
            own = np.flatnonzero([place[0] == k for place in self.places])
            if len(own) and self.length >= SHORTEST and record.cutoff is not None:
                before, after = self._cut(k, record.x), self._cut(k, self._passed[k])
                columns = np.moveaxis(x[own] - before, 0, 1)  # (n, n_pieces, n_states)
                left = _low_passed(record, columns.reshape(self.length, -1))
                found[own] = after + np.moveaxis(left.reshape(columns.shape), 1, 0)
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
    """Return a record with the inputs of runs that are low-passed afterwards."""
    made = record.preparation
    if made is None or made.cutoff is None or made.u is None:
        return record
    if made.decimation == 1:
        return replace(record, u=made.u[made.trim : made.t.size - made.trim][slice(*made.rows)])
    wide = float(np.clip(0.5 / (OVER * record.dt), made.cutoff, WIDER * made.cutoff))
    return replace(record, u=replace(made, cutoff=wide).lowpass(made.u))


def straightened(record: Record) -> Record:
    """Return a record whose inputs, straight between samples, act as the smooth ones do.

    Straight lines fall short of a sine by (omega dt)^2 / 12.
    """
    if record.preparation is None or record.u is None or len(record) < SHORTEST:
        return record
    u = record.u.copy()
    u[1:-1] -= np.diff(record.u, n=2, axis=0) / 12.0
    return replace(record, u=u)
