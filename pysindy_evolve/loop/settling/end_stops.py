"""Say of a dead zone with one end on which side of it the stop stands.

Beside a spring and an offset max(q - c, 0) and max(c - q, 0) are one force, with another spring.
Of the two, the stop is the one beyond which the force is steeper.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...terms import variable
from ..effects.candidate import OFFSET, Candidate
from ..effects.missing import fitted_terms
from ..effects.stops import begun_at_same, is_stop
from ..evidence.findings import Finding, with_findings
from ..evidence.scoring import quick_fit
from ..given.design import Design
from ..given.segments import Segments

__all__ = ["with_stops_on_steep_side"]

# Of the largest magnitude of the position: how far from its end a stop is looked at.
DISTANCE_FROM_END = 1e-3


def with_stops_on_steep_side(
    declared: Design, findings: Sequence[Finding], part: Segments
) -> list[Finding]:
    """Return findings in which stops stand on the steeper side, where the model leaves that open.

    Parameters
    ----------
    declared : Design
        The model at the start.
    findings : sequence of Finding
        What was found.
    part : Segments
        Pieces of the training records.

    Returns
    -------
    list of Finding
    """
    return [_with_stop_on_steep_side(declared, findings, finding, part) for finding in findings]


def _with_stop_on_steep_side(
    declared: Design, findings: Sequence[Finding], finding: Finding, part: Segments
) -> Finding:
    candidate, shape = finding.candidate, finding.candidate.shape
    if shape is None or not is_stop(candidate) or candidate.partners:
        return finding
    whole, end = with_findings(declared, findings), shape.branch * shape.values[0]
    if not _is_open(candidate, whole) or _is_on_steep_side(candidate, end, whole, part):
        return finding
    (other,) = begun_at_same(candidate)
    return finding.with_candidate(other, whole)


def _is_open(candidate: Candidate, design: Design) -> bool:
    """Tell whether a spring and an offset are fitted beside a stop of one position."""
    if len(candidate.variables) != 1:
        return False
    (position,) = candidate.variables
    return {(candidate.state, OFFSET), (candidate.state, variable(position))} <= fitted_terms(
        design
    )


def _is_on_steep_side(candidate: Candidate, end: float, design: Design, part: Segments) -> bool:
    """Tell whether a stop acts where the rate changes faster over the position."""
    (position,) = candidate.variables
    step = DISTANCE_FROM_END * float(np.abs(part.z[..., position]).max())
    rows = np.tile(part.z[..., :-1].mean(axis=(0, 1)), (3, 1))
    rows[:, position] = end + step * np.array([-1.0, 0.0, 1.0])
    n = part.n_states
    rates = quick_fit(design, part).evaluate(rows[:, :n], rows[:, n:], np.zeros(3))
    slope_below, slope_above = np.abs(np.diff(rates[:, candidate.state]))
    below, _, above = candidate.terms[0].evaluate(rows)
    return bool(slope_above > slope_below) == bool(above > below)
