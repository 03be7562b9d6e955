"""One number in place of two, in effects that are one expression in the equations of two states."""

from __future__ import annotations

import math
from collections.abc import Sequence

from ..effects.candidate import Candidate
from ..effects.partners import joined, partnerships
from ..evidence.findings import Finding, at_numbers, with_columns
from ..evidence.scoring import MARGIN, score, tuned
from ..given.design import Design
from ..given.segments import Segments

__all__ = ["with_shared_numbers"]

N_ROUNDS = 2  # numbers tuned apart may lie as far from their place on the grid as is looked at


def with_shared_numbers(
    declared: Design, findings: Sequence[Finding], part: Segments
) -> list[Finding]:
    """Return findings in which partners have the same numbers, tuned together.

    Unless numbers of their own do clearly better: two valves behind one signal may saturate at two
    places.

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
        Those that share their numbers already stay as they are.
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
    """Return the numbers that partners share; None if they do so already, or had better not."""
    apart = joined(group)
    begun = dict.fromkeys(c.shape.values for c in group if c.shape is not None)
    if len(begun) == 1:
        return None
    together = [apart.at(values) for values in begun]
    for _ in range(N_ROUNDS):
        together = [tuned(one, design, part) for one in together]
    # In one call, for the errors are weighed by what all columns together leave.
    gains = {s.group[0]: s.value for s in score(design, part, [apart, *together], pairs=False)}
    best = max(together, key=lambda one: gains.get(one, -math.inf))
    least = gains.get(apart, -math.inf) - MARGIN
    return best.shape.values if best.shape and gains.get(best, -math.inf) > least else None
