"""Look again at what was found: exchange effects, merge them, drop them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np

from ..effects.candidate import Candidate
from ..effects.missing import candidates
from ..effects.stops import begun_at_same
from ..evidence.findings import Finding, MemoryFinding, excluding, is_needed, with_columns
from ..evidence.scoring import LEAD, MARGIN, PRICE, score, tuned
from ..given.design import Design
from ..given.segments import Segments
from .marginality import without_parents

__all__ = ["exchange", "merged", "prune"]


def exchange(
    declared: Design, findings: Sequence[Finding], part: Segments, *, latest: bool = False
) -> list[Finding]:
    """Replace an earlier effect, or the latest too, where another one does better by now.

    Effects that only work together may enter one after the other, and the first of them under a
    wrong name: cubic damping for drag, as long as the friction is not there yet.
    """
    findings = list(findings)
    for place, finding in enumerate(findings if latest else findings[:-1]):
        if isinstance(finding, MemoryFinding):
            continue
        rest = excluding(findings, finding)
        if is_needed(finding, rest):
            continue
        design = with_columns(declared, rest)
        others = candidates(design, part.ranges)
        allowed = [c for c in others if finding.candidate.name not in c.must_beat]
        options = dict.fromkeys([*allowed, finding.candidate])
        scores = score(design, part, list(options), pairs=False)
        own = next((s for s in scores if s.group == (finding.candidate,)), None)
        if own is None:
            continue
        better, n_own = scores[0].group[0], finding.candidate.n_columns
        least = PRICE if finding.candidate.is_straight else MARGIN  # what bends must do much better
        least += LEAD * max(better.n_columns - n_own, 0)  # and what has more coefficients
        if scores[0].value > own.value + least:
            there = finding.with_candidate(better, design)
            findings[place] = replace(there, score=scores[0].value)
    return findings


def merged(declared: Design, findings: Sequence[Finding], part: Segments) -> list[Finding]:
    """Put one effect in the place of two that do no better together.

    Gravity on an arm about the horizontal is first seen as an offset, for most of its cosine is
    one, and then as a quadratic stiffness, which is the rest.
    """
    for first, second in combinations(findings, 2):
        one = _in_place_of(first, second, declared, findings, part)
        if one is not None:
            rest = excluding(findings, first, second)
            return merged(declared, [*rest, one], part)
    return list(findings)


def _in_place_of(
    first: Finding, second: Finding, declared: Design, findings: Sequence[Finding], part: Segments
) -> Finding | None:
    pair = (first.candidate, second.candidate)
    rest = excluding(findings, first, second)
    if (
        isinstance(first, MemoryFinding)
        or isinstance(second, MemoryFinding)
        or pair[0].state != pair[1].state
        or is_needed(first, rest)
        or is_needed(second, rest)
    ):
        return None
    design = with_columns(declared, rest)
    own = [c for c in pair if not c.contains_parents]
    # What refines an effect has to pass a test of its own, and a stop has a place besides.
    offered = candidates(design, part.ranges)
    others = [
        c for c in offered if not (c.must_beat or (c.contains_parents and c.shape is not None))
    ]
    mirrors = [tuned(there, design, part) for c in pair for there in begun_at_same(c)]
    options = [*mirrors, *(c for c in others if c not in own)]
    free = dict.fromkeys(replace(c, parents=()) for c in (*options, *pair))
    # In one call, for the errors are weighed by what all columns together leave.
    scores = score(design, part, list(free))
    names = {replace(c, parents=()) for c in pair}
    both = max((2.0 * s.value for s in scores if set(s.group) == names), default=np.inf)
    alone = [s for s in scores if len(s.group) == 1 and _is_single(s.group[0], pair, own)]
    best = max(alone, key=lambda s: s.value, default=None)
    if best is None:
        return None
    (candidate,) = best.group
    # A filter bends a kink, of which an offset makes a little.
    least = PRICE if any(candidate.terms == there.terms for there in mirrors) else MARGIN
    if best.value < both - least:
        return None
    weaker = max(first, second, key=lambda f: f.p_value)
    one = weaker.with_candidate(candidate, design)
    return replace(one, score=best.value, step=min(first.step, second.step))


def _is_single(
    candidate: Candidate, pair: Sequence[Candidate], excluded: Sequence[Candidate]
) -> bool:
    """Tell whether a candidate is one column of the pair's equation, and not one of the pair."""
    taken = {(c.name, c.terms) for c in excluded}
    return (
        candidate.state == pair[0].state
        and len(candidate.terms) == 1
        and (candidate.name, candidate.terms) not in taken
    )


def prune(declared: Design, findings: Sequence[Finding], part: Segments) -> list[Finding]:
    """Drop effects that later ones made superfluous, unless one of those needs them."""
    for finding in list(findings):
        rest = excluding(findings, finding)
        if isinstance(finding, MemoryFinding) or finding.by_runs:  # the derivative is blind to it
            continue
        if is_needed(finding, rest):
            continue
        design = with_columns(declared, rest)
        scores = score(design, part, [finding.candidate], pairs=False)
        if not scores or scores[0].value < MARGIN:
            findings = rest
    return without_parents(declared, findings, part)
