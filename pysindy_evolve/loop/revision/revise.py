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
from ..evidence.ranking import Score
from ..evidence.scoring import EXTRA_LEAD_LOG, MIN_GAIN_LOG, PRICE_PER_NODE_LOG, score, tuned
from ..given.design import Design
from ..given.segments import Segments
from .marginality import without_parents


def exchange(
    declared: Design, findings: Sequence[Finding], part: Segments, *, latest: bool = False
) -> list[Finding]:
    """Replace each earlier effect, or the latest too, where another one does better by now.

    Of effects that only work together, the first may enter under a wrong name: cubic damping
    instead of drag, as long as the friction is missing.
    """
    findings = list(findings)
    for place, finding in enumerate(findings if latest else findings[:-1]):
        if isinstance(finding, MemoryFinding):
            continue
        rest = excluding(findings, finding)
        if is_needed(finding, rest):
            continue
        design = with_columns(declared, rest)
        offered = candidates(design, part.ranges)
        allowed = [c for c in offered if finding.candidate.name not in c.must_beat]
        options = dict.fromkeys([*allowed, finding.candidate])
        scores = score(design, part, list(options), pairs=False)
        present = next((s for s in scores if s.group == (finding.candidate,)), None)
        if present is None:
            continue
        better, n_present = scores[0].group[0], finding.candidate.n_columns
        # To replace a straight line, or to add coefficients, an effect must do much better.
        least = PRICE_PER_NODE_LOG if finding.candidate.is_straight else MIN_GAIN_LOG
        least += EXTRA_LEAD_LOG * max(better.n_columns - n_present, 0)
        if scores[0].value > present.value + least:
            exchanged = finding.with_candidate(better, design)
            findings[place] = replace(exchanged, score=scores[0].value)
    return findings


def merged(declared: Design, findings: Sequence[Finding], part: Segments) -> list[Finding]:
    """Replace two effects by one that does as well as both together.

    Gravity on an arm near the horizontal is first seen as an offset, since its cosine is nearly
    one, and then as a quadratic stiffness, which is the rest of the cosine.
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
    """Return the effect that does as well as two together; None if there is none."""
    rest = excluding(findings, first, second)
    if (
        isinstance(first, MemoryFinding)
        or isinstance(second, MemoryFinding)
        or first.candidate.state != second.candidate.state
        or is_needed(first, rest)
        or is_needed(second, rest)
    ):
        return None
    design = with_columns(declared, rest)
    best = _best_for_pair((first.candidate, second.candidate), design, part)
    if best is None:
        return None
    weaker = max(first, second, key=lambda f: f.p_value)
    merged_finding = weaker.with_candidate(best.group[0], design)
    return replace(merged_finding, score=best.value, step=min(first.step, second.step))


def _best_for_pair(
    pair: tuple[Candidate, Candidate], design: Design, part: Segments
) -> Score | None:
    """Return the score of the best single effect, if a pair together does hardly better.

    `design` is the model without the pair.
    """
    excluded = [c for c in pair if not c.contains_parents]
    # Refinements have to pass a test of their own, and a stop brings its position as a number.
    offered = candidates(design, part.ranges)
    allowed = [
        c for c in offered if not (c.must_beat or (c.contains_parents and c.shape is not None))
    ]
    # Dead zones with one end that begin at the kink of one of the two.
    mirrors = [tuned(mirror, design, part) for c in pair for mirror in begun_at_same(c)]
    options = [*mirrors, *(c for c in allowed if c not in excluded)]
    own = [replace(c, parents=(), never_paired=False) for c in pair]  # to be scored together
    free = dict.fromkeys([*(replace(c, parents=()) for c in options), *own])
    # Scored in one call, since the noise weights depend on all columns together.
    scores = score(design, part, list(free))
    pair_score = max((2.0 * s.value for s in scores if set(s.group) == set(own)), default=np.inf)
    singles = [s for s in scores if len(s.group) == 1 and _is_single(s.group[0], pair, excluded)]
    best = max(singles, key=lambda s: s.value, default=None)
    if best is None:
        return None
    # A filter rounds a kink, and an offset makes up for a part of that.
    is_mirror = any(best.group[0].terms == mirror.terms for mirror in mirrors)
    least = PRICE_PER_NODE_LOG if is_mirror else MIN_GAIN_LOG
    return None if best.value < pair_score - least else best


def _is_single(
    candidate: Candidate, pair: Sequence[Candidate], excluded: Sequence[Candidate]
) -> bool:
    """Tell whether a candidate is a single column of the pair's equation, and not excluded."""
    taken = {(c.name, c.terms) for c in excluded}
    return (
        candidate.state == pair[0].state
        and len(candidate.terms) == 1
        and (candidate.name, candidate.terms) not in taken
    )


def prune(declared: Design, findings: Sequence[Finding], part: Segments) -> list[Finding]:
    """Drop effects that later ones made superfluous, unless another one needs them."""
    for finding in list(findings):
        rest = excluding(findings, finding)
        if isinstance(finding, MemoryFinding) or finding.by_runs:  # the derivative does not show it
            continue
        if is_needed(finding, rest):
            continue
        design = with_columns(declared, rest)
        scores = score(design, part, [finding.candidate], pairs=False)
        if not scores or scores[0].value < MIN_GAIN_LOG:
            findings = rest
    return without_parents(declared, findings, part)
