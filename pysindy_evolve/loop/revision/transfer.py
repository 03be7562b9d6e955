"""Effects that are another one in each record: a forcing whose phase differs, a load, a zero.

What depends on nothing but the time is fitted to all records with one number, and so it explains a
part of each even where every record has its own. No fixed term can be that.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..evidence.findings import Finding, MemoryFinding, SensorFinding, is_needed, with_findings
from ..fitting.linear import solve_gram
from ..fitting.residual import derivative_grams
from ..given.design import Design
from ..given.segments import Segments

__all__ = ["last_untransferred"]

MOST_LOST = 0.2  # of what it would gain with numbers of their own: phases 50 degrees apart


def last_untransferred(
    declared: Design, findings: Sequence[Finding], part: Segments
) -> Finding | None:
    """Return the last effect of the time alone that differs between records.

    Parameters
    ----------
    declared : Design
        The model at the start.
    findings : sequence of Finding
        What was found, in this order.
    part : Segments
        Pieces of the training records.

    Returns
    -------
    Finding or None
        None of a single record, and where no effect differs.
    """
    records = np.array([record for record, _ in part.places])
    if part.by_trajectory or len(np.unique(records)) < 2:
        return None
    design = with_findings(declared, findings)
    grams = derivative_grams(part, design, design.columns)
    coef = solve_gram(grams.sum(axis=0))
    by_record = [grams[records == record].mean(axis=0) for record in np.unique(records)]
    for finding in reversed(findings):
        if _is_of_time(finding, design) and not is_needed(
            finding, [other for other in findings if other is not finding]
        ):
            own = [design.columns.index(column) for column in finding.columns]
            if _differs(own, coef, by_record):
                return finding
    return None


def _is_of_time(finding: Finding, design: Design) -> bool:
    """Tell whether nothing that was measured acts in an effect."""
    if isinstance(finding, MemoryFinding | SensorFinding):
        return False
    time = len(design.states) + len(design.inputs)
    return finding.candidate.variables <= {time} and set(finding.columns) <= set(design.columns)


def _differs(own: Sequence[int], coef: np.ndarray, grams: Sequence[np.ndarray]) -> bool:
    """Tell whether columns explain much more in a record with coefficients of its own."""
    lost, gained = [], []
    for gram in grams:
        inner = gram[np.ix_(own, own)]
        wrong = np.linalg.pinv(inner) @ (gram[own, -1] - gram[own, :-1] @ coef)
        right = coef[own] + wrong
        lost.append(float(wrong @ inner @ wrong))
        gained.append(float(right @ inner @ right))
    return max(lost) > MOST_LOST * float(np.mean(gained))
