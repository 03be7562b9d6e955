"""Coefficients that vary in proportion to a variable, or rather as a hyperbola of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from ..effects.varying import hyperbolas
from ..evidence.findings import Finding, excluding, is_needed, with_columns
from ..evidence.scoring import HIDDEN_STATE_LEAD_LOG, score, tuned
from ..given.design import Design
from ..given.segments import Segments

__all__ = ["with_hyperbolas"]


def with_hyperbolas(declared: Design, findings: Sequence[Finding], part: Segments) -> list[Finding]:
    """Return findings with a hyperbola in the place of a product that does clearly worse.

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
        As many as before.
    """
    kept = list(findings)
    for place, finding in enumerate(kept):
        rest = excluding(kept, finding)
        design = with_columns(declared, rest)
        options = hyperbolas(finding.candidate, design, part.ranges.largest)
        if not options or is_needed(finding, rest):
            continue
        ranked = score(design, part, [finding.candidate, *options], pairs=False)
        own = next((s for s in ranked if s.group == (finding.candidate,)), None)
        if own is None or ranked[0].group == own.group:
            continue
        (best,) = score(design, part, [tuned(ranked[0].group[0], design, part)], pairs=False)[:1]
        if best.value > own.value + HIDDEN_STATE_LEAD_LOG:  # it has one more number
            bent = finding.with_candidate(best.group[0], design)
            kept[place] = replace(bent, score=best.value)
    return kept
