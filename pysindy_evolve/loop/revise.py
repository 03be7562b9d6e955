"""Look again at what was found: exchange effects, drop them, name what could replace them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .design import Design
from .effects import candidates
from .recall import MemoryFinding
from .rivals import rivals_of
from .scoring import MARGIN, columns_of, score
from .segments import Segments, ranges
from .step import Finding

__all__ = ["contested", "exchange", "prune"]


def exchange(declared: Design, findings: list[Finding], part: Segments) -> list[Finding]:
    """Replace an earlier effect where another one does better beside what was found later.

    Effects that only work together may enter one after the other, and the first of them under a
    wrong name: cubic damping for drag, as long as the friction is not there yet.
    """
    for place, finding in enumerate(findings[:-1]):
        if isinstance(finding, MemoryFinding):
            continue
        rest = [f for k, f in enumerate(findings) if k != place]
        parents = {parent for f in rest for parent in f.candidate.parents}
        if parents & set(finding.candidate.terms):
            continue
        design = declared.adding(column for f in rest for column in f.columns)
        variables = part.z.reshape(-1, part.z.shape[-1])
        options = dict.fromkeys([*candidates(design, *ranges(variables)), finding.candidate])
        scores = score(design, part, list(options), pairs=False)
        own = next((s for s in scores if s.group == (finding.candidate,)), None)
        if own is not None and scores[0].value > own.value + MARGIN:
            better = scores[0].group[0]
            findings[place] = replace(
                finding,
                candidate=better,
                columns=columns_of(better, design),
                score=scores[0].value,
            )
    return findings


def prune(declared: Design, findings: list[Finding], part: Segments) -> list[Finding]:
    """Drop effects that later ones made superfluous, unless one of those needs them."""
    for finding in list(findings):
        rest = [f for f in findings if f is not finding]
        if isinstance(finding, MemoryFinding):
            continue
        needed = {parent for f in rest for parent in f.candidate.parents}
        if needed & set(finding.candidate.terms):
            continue
        design = declared.adding(column for f in rest for column in f.columns)
        scores = score(design, part, [finding.candidate], pairs=False)
        if not scores or scores[0].value < MARGIN:
            findings = rest
    return findings


def contested(
    declared: Design,
    findings: list[Finding],
    part: Segments,
    level: float,
    rng: np.random.Generator,
) -> list[Finding]:
    """Note with each effect those that could stand in its place beside all the others.

    One that a later effect needs has no rivals: both would have to go.
    """
    judged = []
    for finding in findings:
        rest = [f for f in findings if f is not finding]
        needed = {parent for f in rest for parent in f.candidate.parents}
        design = declared.adding(column for f in rest for column in f.columns)
        free = not isinstance(finding, MemoryFinding) and not needed & set(finding.candidate.terms)
        if free:
            found = rivals_of(finding.candidate, design, part, level, rng)
            finding = replace(finding, rivals=found)
        judged.append(finding)
    return judged
