"""One number instead of two, where effects of two equations are the same expression."""

from __future__ import annotations

import math
from collections.abc import Sequence

from ..effects.candidate import Candidate
from ..effects.partners import joined, partnerships
from ..evidence.findings import Finding, at_numbers, with_columns
from ..evidence.scoring import MIN_GAIN_LOG, score, tuned
from ..given.design import Design
from ..given.segments import Segments

N_ROUNDS = 2  # of tuning: the shared number may lie beyond the reach of a single one


def with_shared_numbers(
    declared: Design, findings: Sequence[Finding], part: Segments
) -> list[Finding]:
    """Return findings in which partners have the same numbers, tuned together.

    Partners keep different numbers where these do clearly better: two valves behind one signal may
    saturate at two places.

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
        Partners that share their numbers already stay as they are.
    """
    kept = list(findings)
    for places in partnerships([f.candidate for f in kept]):
        group = [kept[place].candidate for place in places]
        design = with_columns(declared, [f for k, f in enumerate(kept) if k not in places])
        values = _shared(group, design, part)
        if values is not None:
            for place in places:
                kept[place] = at_numbers(kept[place], values, declared)
    return kept


def _shared(group: Sequence[Candidate], design: Design, part: Segments) -> tuple[float, ...] | None:
    """Return the numbers that partners share; None if they do already, or do worse with them."""
    unshared = joined(group)
    initial = dict.fromkeys(c.shape.values for c in group if c.shape is not None)
    if len(initial) == 1:
        return None
    together = [unshared.at(values) for values in initial]
    for _ in range(N_ROUNDS):
        together = [tuned(effect, design, part) for effect in together]
    # Scored in one call, since the noise weights depend on all columns together.
    gains = {s.group[0]: s.value for s in score(design, part, [unshared, *together], pairs=False)}
    best = max(together, key=lambda effect: gains.get(effect, -math.inf))
    least = gains.get(unshared, -math.inf) - MIN_GAIN_LOG
    return best.shape.values if best.shape and gains.get(best, -math.inf) > least else None
