"""Drop what a term with numbers in it makes superfluous once these are tuned without the rest.

Where no name fits, names that come close may enter before the term is grown: a square and a cube of
the input for the exponential of a voltage. Beside them its numbers settle where they fill the gaps,
and so each of them still seems needed. So it is with a Coulomb friction that came in before the
hysteresis it is a part of.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..effects.names import EVOLVED, HYSTERESIS
from ..effects.shaping import shape_of
from ..evidence.findings import Finding, MemoryFinding, excluding, is_needed, with_columns
from ..evidence.scoring import MARGIN, tuned
from ..evidence.spectral import spectral_grams
from ..evidence.trace import fold_errors
from ..given.design import Design
from ..given.segments import Segments

__all__ = ["thinned"]

FILLS_GAPS = (EVOLVED, HYSTERESIS)


def thinned(declared: Design, findings: Sequence[Finding], part: Segments) -> list[Finding]:
    """Return findings without those that a grown term or a hysteresis, tuned anew, can do without.

    All that were named before the term are dropped together if the rest predicts as well, else one
    by one.

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
    for grown in findings:
        named = [f for f in findings if _came_before(f, grown)]
        for dropped in (named, *([one] for one in named)) if named else ():
            fewer = _without(declared, findings, dropped, grown, part)
            if fewer:
                return thinned(declared, fewer, part)
    return list(findings)


def _came_before(one: Finding, grown: Finding) -> bool:
    """Tell whether a term may have been grown into the gaps that one effect has left."""
    earlier = one.step < grown.step and one.candidate.state == grown.candidate.state
    # The derivative is blind to what only runs show, and what remembers adds no term.
    shows = not (isinstance(one, MemoryFinding) or one.by_runs)
    return grown.candidate.name in FILLS_GAPS and earlier and shows


def _without(
    declared: Design,
    findings: Sequence[Finding],
    dropped: Sequence[Finding],
    grown: Finding,
    part: Segments,
) -> list[Finding]:
    """Return findings without some, a grown term tuned for it; none if these are needed."""
    rest = excluding(findings, grown, *dropped)
    shape = shape_of(grown.candidate)
    if shape is None or any(is_needed(f, (*rest, grown)) for f in dropped):
        return []
    design = with_columns(declared, rest)
    alone = replace(grown.candidate, parents=(), shape=shape)
    there = replace(grown.candidate, terms=tuned(alone, design, part).terms)
    other = grown.with_candidate(there, design)
    loss = _loss(design, [*dropped, grown], [other], part)
    if loss >= MARGIN * len(dropped):
        return []
    return [other if f is grown else f for f in findings if f not in dropped]


def _loss(design: Design, many: Sequence[Finding], few: Sequence[Finding], part: Segments) -> float:
    """Return log(error with few / error with many), each fold predicted from the others."""
    sides = [[column for f in side for column in f.columns] for side in (few, many)]
    grams = spectral_grams(part, design, [*design.columns, *sides[0], *sides[1]])
    fixed, first = len(design.columns), len(design.columns) + len(sides[0])
    models = [range(first), [*range(fixed), *range(first, first + len(sides[1]))]]
    errors = [fold_errors(grams, np.array([list(m)]), part.folds).sum() for m in models]
    return float(np.log(errors[0] / errors[1]))
