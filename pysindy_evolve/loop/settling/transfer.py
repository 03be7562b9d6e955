"""Effects whose coefficients differ from record to record: the phase of a forcing, a load, a zero.

What depends on nothing but the time is fitted to all records with one number, and so it explains a
part of each even where every record has its own. No fixed term can be that. Nor is a state that
nobody measured and that relaxes slowly, where a load in each record explains as much: it begins
where each record says, and so is another load in each.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..effects.candidate import OFFSET
from ..evidence.findings import (
    Finding,
    MemoryFinding,
    SensorFinding,
    excluding,
    is_needed,
    with_findings,
)
from ..fitting.linear import solve_gram, summed
from ..fitting.residual import derivative_grams
from ..given.design import Design, in_state
from ..given.segments import Segments

MAX_LOST_SHARE = 0.2  # of what it would gain with numbers of their own: phases 50 degrees apart
MAX_SQUARES_WITH_LOADS = 1.05  # times the squares that are left
# Times the squares that are left, where records have numbers of their own.
MAX_SQUARES_BY_RECORD = 0.8
# Of what an effect explains, at least, it must explain within the records.
MIN_SHARE_WITHIN_RECORDS = 0.5


def last_untransferred(
    declared: Design, findings: Sequence[Finding], part: Segments
) -> Finding | None:
    """Return the last effect that is another one in each record, or stands for such a difference.

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
    records = np.unique([record for record, _ in part.places], return_inverse=True)[1]
    if part.by_trajectory or records[-1] == 0:
        return None
    design = with_findings(declared, findings)
    for finding in reversed(findings):
        rest = excluding(findings, finding)
        if is_needed(finding, rest) or not set(finding.columns) <= set(design.columns):
            continue
        if _is_of_time_alone(finding, design) and _differs(finding, design, part, records):
            return finding
        without = with_findings(declared, rest)
        remembers = len(without.paths) < len(design.paths)
        if remembers and _is_load(without, design, part, records):
            return finding
        if not remembers and _tells_records_apart(without, design, part, records):
            return finding
    return None


def _is_of_time_alone(finding: Finding, design: Design) -> bool:
    """Tell whether nothing that was measured acts in an effect."""
    if isinstance(finding, MemoryFinding | SensorFinding):
        return False
    return finding.candidate.variables <= {design.time}


def _differs(finding: Finding, design: Design, part: Segments, records: np.ndarray) -> bool:
    """Tell whether an effect explains much more in a record with coefficients of its own."""
    grams = derivative_grams(part, design, design.columns)
    coef = solve_gram(grams.sum(axis=0))
    own = [design.columns.index(column) for column in finding.columns]
    lost, gained = [], []
    for gram in summed(grams, records):
        inner = gram[np.ix_(own, own)]
        wrong = np.linalg.pinv(inner) @ (gram[own, -1] - gram[own, :-1] @ coef)
        right = coef[own] + wrong
        lost.append(float(wrong @ inner @ wrong))
        gained.append(float(right @ inner @ right))
    return max(lost) > MAX_LOST_SHARE * float(np.mean(gained))


def _is_load(few: Design, many: Design, part: Segments, records: np.ndarray) -> bool:
    """Tell whether a design with a load in each record does as well as one that remembers more."""
    own = derivative_grams(part, many, many.columns).sum(axis=0)
    for state in few.open_states:
        load = in_state("load", OFFSET, state, len(few.states))
        grams = summed(derivative_grams(part, few, (load, *few.columns)), records)
        freed = sum(gram - np.outer(gram[0], gram[0]) / gram[0, 0] for gram in grams)[1:, 1:]
        if _left(freed) <= MAX_SQUARES_WITH_LOADS * _left(own):
            return True
    return False


def _tells_records_apart(few: Design, many: Design, part: Segments, records: np.ndarray) -> bool:
    """Tell whether what an effect explains is that records differ in numbers, or in their load."""
    if few.columns == many.columns:  # a memory
        return False
    explained, best = _gained(few, many, part)
    loads = [in_state("load", OFFSET, state, len(few.states)) for state in few.open_states]
    for load in ((), loads):
        within, left = _gained(few.adding(load), many.adding(load), part, records)
        if (
            within + left < MAX_SQUARES_BY_RECORD * best
            and within < MIN_SHARE_WITHIN_RECORDS * explained
        ):
            return True
    return False


def _gained(
    few: Design, many: Design, part: Segments, records: np.ndarray | None = None
) -> tuple[float, float]:
    """Return what more columns gain, and what they leave; of each record by itself if asked."""
    sides = [derivative_grams(part, design, design.columns) for design in (few, many)]
    each = [[grams.sum(axis=0)] if records is None else summed(grams, records) for grams in sides]
    before, after = (sum(map(_left, grams)) for grams in each)
    return before - after, after


def _left(gram: np.ndarray) -> float:
    """Return what the columns of a Gram matrix leave of its target."""
    left = np.append(-solve_gram(gram), 1.0)
    return float(left @ gram @ left)
