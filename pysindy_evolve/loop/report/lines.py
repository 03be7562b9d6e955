"""Lines that the residuals of all of several records share, and no input has.

A forcing whose phase differs from record to record is one. No fixed term can be it, so it stays
without a name; but a model that leaves it is not complete.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...signals import Record
from ..effects.periodic import FEWEST_FREQUENCIES, lines_of
from .left import residual_of

if TYPE_CHECKING:
    from .report import LoopReport

__all__ = ["shared_lines"]

LOBE = 3.0  # resolutions of a record, about a line, that are the same line


def shared_lines(report: LoopReport) -> list[tuple[str, float]]:
    """Return states and frequencies, in cycles per unit of t; none of a single record."""
    model, records = report.after.model, report.train
    if len(records) < 2 or model.n_algebraic or not all(map(_knows_its_noise, records)):
        return []
    width = 1.0 / min(record.t[-1] - record.t[0] for record in records)
    left = [residual_of(model, record) for record in records]
    shared: list[tuple[str, float]] = []
    for k, state in enumerate(report.before.model.states):
        pairs = zip(records, left, strict=True)
        first, *others = ([*map(float, _lines_of(record, one[:, k]))] for record, one in pairs)
        kept: list[float] = []
        for line in first:
            everywhere = all(any(abs(line - o) < width for o in those) for those in others)
            if everywhere and all(abs(line - other) > LOBE * width for other in kept):
                kept.append(line)
        shared += [(state, line) for line in kept]
    return shared


def _lines_of(record: Record, left: np.ndarray) -> list[float]:
    drivers = record.x[:, :0] if record.u is None else record.u
    return lines_of(left, drivers, record.dt)


def _knows_its_noise(record: Record) -> bool:
    """Tell whether the low-pass of a record left frequencies enough to know a line from noise."""
    made = record.preparation
    cutoff = 0.5 / record.dt if made is None or made.cutoff is None else made.cutoff
    return bool(cutoff * (record.t[-1] - record.t[0]) >= FEWEST_FREQUENCIES)
