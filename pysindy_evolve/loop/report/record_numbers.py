"""Declared numbers that differ between records, such as a friction that is less once it is warm.

Each record by itself is then explained well, and all of them together by no fixed term.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...hidden_states.memory_equations import as_acting
from ..fitting.fit import derivative_square, refit
from ..given.rows import variables_of

if TYPE_CHECKING:
    from .report import LoopReport

__all__ = ["numbers_by_record"]

BETTER = 0.8  # times the squares that are left, where each record has numbers of its own
TRACE = 0.01  # of a number: records that differ by less are the same to anybody
WEIGHTY = 0.5  # of what the number that differs most moves in the rates


def numbers_by_record(report: LoopReport) -> dict[str, np.ndarray]:
    """Return what parameters are in each training record, of those that are not the same.

    Those that matter most. Empty of a single record, and where all records share their numbers.
    Declared ones only: two effects may have the same name.
    """
    design = report.design
    if len(report.train) < 2 or not design.columns:
        return {}
    records = [as_acting(report.equations, record)[1] for record in report.train]
    pooled = refit(design, records, "derivative")
    own = np.array([refit(design, [record], "derivative") for record in records])
    apart = zip(records, own, strict=True)
    left = sum(derivative_square(design, [record], coef) for record, coef in apart)
    if left >= BETTER * derivative_square(design, records, pooled):
        return {}
    sizes = [
        np.sqrt(np.mean([np.mean(c.evaluate(variables_of(r)) ** 2) for r in records]))
        for c in design.columns
    ]
    moved = np.ptp(own, axis=0) * np.array(sizes)
    return {
        column.name: own[:, k]
        for k, column in enumerate(design.columns)
        if column.name.isidentifier()
        and column.name in report.before.parameters
        and moved[k] >= WEIGHTY * moved.max()
        and np.ptp(own[:, k]) > _by_chance(report, column.name)
        and np.ptp(own[:, k]) > TRACE * np.abs(own[:, k]).max()
    }


def _by_chance(report: LoopReport, name: str) -> float:
    """Return by how much a parameter may differ that is the same in all records.

    As the largest and the smallest of a few draws, which lie about an interval of one apart.
    """
    low, high = report.after.parameter_intervals.get(name, np.zeros(2))
    return float(high - low) * np.sqrt(len(report.train))
