"""Lines that the residuals of all of several records share, and no input has.

A forcing whose phase differs from record to record is one. No fixed term can be it, so it stays
without a name; but a model that leaves it is not complete, if it is most of what is left.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ...signals import Record
from ..effects.lines import FEWEST_FREQUENCIES
from ..effects.periodic import lines_of
from .residuals import residual_of

if TYPE_CHECKING:
    from .report import LoopReport

__all__ = ["Line", "shared_lines"]

MOST = 0.5  # share of what is left of a derivative: rigs hum without lacking anything
LEAST = 0.01  # the same: harmonics of a motion are lines as well, of next to nothing
NEAR_CUTOFF = 0.9  # of it: above, a line is what the filter left of a motion that it cut
LOBE = 3.0  # resolutions of a record, about a line, that are the same line


@dataclass(frozen=True)
class Line:
    """A line in the residual of a state: cycles per unit of t, and its least share of a record."""

    state: str
    frequency: float
    share: float

    @property
    def is_most(self) -> bool:
        """Whether it is most of what is left in each record, so that the model lacks something."""
        return self.share > MOST


def shared_lines(report: LoopReport) -> list[Line]:
    """Return the lines that all of several training records have; none of a single record."""
    model, records = report.after.model, report.train
    if len(records) < 2 or model.n_algebraic or not all(map(_knows_its_noise, records)):
        return []
    width = 1.0 / min(record.t[-1] - record.t[0] for record in records)
    left = [residual_of(model, record) for record in records]
    shared: list[Line] = []
    for k, state in enumerate(report.before.model.states):
        pairs = zip(records, left, strict=True)
        first, *others = ([*map(float, _lines_of(record, one[:, k]))] for record, one in pairs)
        kept: list[float] = []
        for line in first:
            everywhere = all(any(abs(line - o) < width for o in those) for those in others)
            if everywhere and all(abs(line - other) > LOBE * width for other in kept):
                kept.append(line)
        for line in kept:
            pairs = zip(records, left, strict=True)
            shares = [_share(line, record.t, one[:, k]) for record, one in pairs]
            if min(shares) > LEAST:
                shared.append(Line(state, line, min(shares)))
    return shared


def _share(frequency: float, t: np.ndarray, left: np.ndarray) -> float:
    """Return how much of a residual, (n_samples,), a sine of a frequency explains."""
    waves = np.exp(2j * np.pi * frequency * t)
    columns = np.column_stack([waves.real, waves.imag])
    fitted = columns @ np.linalg.lstsq(columns, left, rcond=None)[0]
    return float(np.sum(fitted**2) / max(np.sum(left**2), np.finfo(float).tiny))


def _lines_of(record: Record, left: np.ndarray) -> list[float]:
    drivers = record.x[:, :0] if record.u is None else record.u
    highest = np.inf if record.cutoff is None else NEAR_CUTOFF * record.cutoff
    return [line for line in lines_of(left, drivers, record.dt) if line < highest]


def _knows_its_noise(record: Record) -> bool:
    """Tell whether the low-pass of a record left frequencies enough to know a line from noise."""
    cutoff = 0.5 / record.dt if record.cutoff is None else record.cutoff
    return bool(cutoff * (record.t[-1] - record.t[0]) >= FEWEST_FREQUENCIES)
