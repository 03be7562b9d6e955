"""Drop the parents beside which an effect had to enter, where they gain nothing.

An absolute value has a mean, so it is first seen as an offset, and may enter only beside one. Once
it is in the model, an offset that does not exist proves superfluous. All parents of an effect are
dropped, or none: friction that differs with the direction is a straight line on either side, whose
parts belong together. Or all but an offset are dropped: a load may pull on a damper that is stiffer
one way.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from ...terms import Call, Sum, of_term
from ..effects.candidate import OFFSET, Candidate
from ..effects.missing import terms_in
from ..effects.names import ASYMMETRIC_FRICTION, NONLINEAR_DAMPING
from ..evidence.findings import Finding, MemoryFinding, excluding, is_needed, with_columns
from ..evidence.scoring import MIN_GAIN_LOG, score
from ..given.design import Design
from ..given.segments import Segments

ALONE = {ASYMMETRIC_FRICTION: NONLINEAR_DAMPING}  # new name without a friction beside it


def without_parents(declared: Design, findings: Sequence[Finding], part: Segments) -> list[Finding]:
    """Return findings without the parents that gain nothing beside their effects.

    Parameters
    ----------
    declared : Design
        The declared model.
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
        rest = excluding(findings, child, *parents)
        for dropped in (parents, [f for f in parents if f.candidate.terms != (OFFSET,)]):
            staying = [f for f in parents if f not in dropped]
            if not dropped or any(is_needed(f, rest) for f in dropped):
                continue
            design = with_columns(declared, (*rest, *staying, child))
            if _gain(dropped, design, part) < MIN_GAIN_LOG * len(dropped):
                orphan = replace(child, candidate=_with_parents(child.candidate, staying))
                kept = [orphan if f is child else f for f in findings if f not in dropped]
                return without_parents(declared, kept, part)
    return [_renamed(finding, findings, declared) for finding in findings]


def _with_parents(candidate: Candidate, parents: Sequence[Finding]) -> Candidate:
    kept = tuple(term for parent in parents for term in parent.candidate.terms)
    return replace(candidate, parents=kept)


def _renamed(finding: Finding, findings: Sequence[Finding], declared: Design) -> Finding:
    """Return a finding, renamed if no friction stands beside it."""
    candidate = finding.candidate
    present = terms_in(with_columns(declared, findings))
    if candidate.name not in ALONE or any(
        _is_sign(term) for state, term in present if state == candidate.state
    ):
        return finding
    return replace(finding, candidate=replace(candidate, name=ALONE[candidate.name]))


def _is_sign(expression: Sum) -> bool:
    atoms = [atom for _, term in expression.parts for atom, _ in term.factors]
    return len(atoms) == 1 and isinstance(atoms[0], Call) and atoms[0].operator.name == "sgn"


def _parents_of(child: Finding, findings: Sequence[Finding], declared: Design) -> list[Finding]:
    """Return the parents that were found, if the derivative showed all that are not declared."""
    state = child.candidate.state
    declared_terms = {of_term(term) for term in declared.terms_of(state)}
    declared_terms |= {term for other, term in terms_in(declared) if other == state}
    wanted = set(child.candidate.parents) - declared_terms
    parents = [
        f
        for f in findings
        if f.candidate.state == child.candidate.state
        and wanted & set(f.candidate.terms)
        and not (isinstance(f, MemoryFinding) or f.by_runs)
    ]
    brought = {term for f in parents for term in f.candidate.terms}
    return parents if brought == wanted else []


def _gain(parents: Sequence[Finding], design: Design, part: Segments) -> float:
    """Return log(error without / error with) all parents of an effect, one or two of them."""
    free = [replace(f.candidate, parents=()) for f in parents]
    scores = score(design, part, free)
    return max((s.value * len(free) for s in scores if len(s.group) == len(free)), default=0.0)
