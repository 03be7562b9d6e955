"""Drop what an effect had to enter beside, where that gains nothing.

An absolute value has a mean, so it is first seen as an offset, and may enter only beside one. Once
it stands there, an offset that was never there shows. All parents of an effect go, or none:
friction that differs with the direction is a straight line on either side, whose parts belong
together.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from ...terms import Sum
from ..effects.candidate import Candidate
from ..evidence.findings import Finding, MemoryFinding, is_needed, with_columns
from ..evidence.scoring import MARGIN, score
from ..given.design import Design
from ..given.segments import Segments

__all__ = ["without_parents"]

ALONE = {"asymmetric Coulomb friction": "nonlinear damping"}  # names where no parent stands


def without_parents(declared: Design, findings: Sequence[Finding], part: Segments) -> list[Finding]:
    """Return findings without the parents that their effects do as well without.

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
    for child in findings:
        parents = _parents_of(child, findings, declared)
        rest = [f for f in findings if f is not child and f not in parents]
        if not parents or any(is_needed(f, rest) for f in parents):
            continue
        design = with_columns(declared, (*rest, child))
        if _gain(parents, design, part) < MARGIN * len(parents):
            alone = replace(child, candidate=_alone(child.candidate))
            kept = [alone if f is child else f for f in findings if f not in parents]
            return without_parents(declared, kept, part)
    return list(findings)


def _alone(candidate: Candidate) -> Candidate:
    return replace(candidate, name=ALONE.get(candidate.name, candidate.name), parents=())


def _parents_of(child: Finding, findings: Sequence[Finding], declared: Design) -> list[Finding]:
    """Return the parents that are not declared, if all were found in the derivative."""
    there = {Sum(((1.0, term),)) for term in declared.terms_of(child.candidate.state)}
    wanted = set(child.candidate.parents) - there
    found = [
        f
        for f in findings
        if f.candidate.state == child.candidate.state
        and wanted & set(f.candidate.terms)
        and not (isinstance(f, MemoryFinding) or f.by_runs)
    ]
    brought = {term for f in found for term in f.candidate.terms}
    return found if brought == wanted else []


def _gain(parents: Sequence[Finding], design: Design, part: Segments) -> float:
    """Return log(error without / error with) all parents of an effect, one or two of them."""
    free = [replace(f.candidate, parents=()) for f in parents]
    scores = score(design, part, free)
    return max((s.value * len(free) for s in scores if len(s.group) == len(free)), default=0.0)
