"""Coefficients that vary in proportion to a variable, or rather as a hyperbola of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..effects.candidate import Candidate
from ..effects.varying_terms import hyperbolas, parabolas
from ..evidence.findings import Finding, excluding, is_needed, with_columns
from ..evidence.ranking import Score
from ..evidence.scoring import EXTRA_LEAD_LOG, score, tuned
from ..given.design import Design
from ..given.segments import Segments


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
        options = hyperbolas(finding.candidate, design, part.ranges)
        if options and not is_needed(finding, rest):
            best = _best(finding.candidate, options, design, part)
            if best is not None:
                kept[place] = replace(
                    finding.with_candidate(best.group[0], design), score=best.value
                )
    return kept


def _best(
    found: Candidate, options: Sequence[Candidate], design: Design, part: Segments
) -> Score | None:
    """Return the score of the best hyperbola, tuned, if it does clearly better than the product.

    It must also do better than a parabola, which has as many numbers: otherwise the coefficient is
    curved, but goes nowhere to infinity.
    """
    first: dict[int, Candidate] = {}
    for scored in score(design, part, options, pairs=False):
        first.setdefault(scored.group[0].branch, scored.group[0])
    bent = [tuned(option, design, part) for option in first.values()]
    ranked = score(design, part, [found, *bent, *parabolas(found, design)], pairs=False)
    values = {scored.group[0]: scored.value for scored in ranked}
    least = values.get(found, np.inf) + EXTRA_LEAD_LOG  # it has one more number
    best = next(iter(ranked), None)  # none where the model's columns can say all of them
    return best if best is not None and best.group[0] in bent and best.value > least else None
