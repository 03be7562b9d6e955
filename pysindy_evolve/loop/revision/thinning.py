"""Drop effects that a grown term or a hysteresis replaces once its numbers are tuned without them.

Where no named effect fits, similar ones may enter before the right term is grown: a square and a
cube of the input instead of the exponential of a voltage. Beside them the numbers of the grown term
settle where it fills the gaps, so each of them still seems needed. The same happens to a Coulomb
friction that entered before the hysteresis of which it is a part.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..effects.names import EVOLVED, HYSTERESIS
from ..effects.shaping import shape_of
from ..evidence.findings import Finding, MemoryFinding, excluding, is_needed, with_columns
from ..evidence.held_out_scores import fold_errors
from ..evidence.scoring import MIN_GAIN_LOG, tuned
from ..evidence.spectral import spectral_grams
from ..given.design import Design
from ..given.segments import Segments

FILLS_GAPS = (EVOLVED, HYSTERESIS)


def thinned(declared: Design, findings: Sequence[Finding], part: Segments) -> list[Finding]:
    """Return findings without those that a grown term or a hysteresis, tuned again, replaces.

    All effects that came before the term are dropped together if the rest predicts as well,
    otherwise one by one.

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
    for grown in findings:
        named = [f for f in findings if _came_before(f, grown)]
        for dropped in (named, *([one] for one in named)) if named else ():
            fewer = _without(declared, findings, dropped, grown, part)
            if fewer:
                return thinned(declared, fewer, part)
    return list(findings)


def _came_before(effect: Finding, grown: Finding) -> bool:
    """Tell whether a grown term may fill the gaps that an earlier effect has left."""
    earlier = effect.step < grown.step and effect.candidate.state == grown.candidate.state
    # Findings of free runs do not show in the derivative, and memories add no term.
    in_derivative = not (isinstance(effect, MemoryFinding) or effect.by_runs)
    return grown.candidate.name in FILLS_GAPS and earlier and in_derivative


def _without(
    declared: Design,
    findings: Sequence[Finding],
    dropped: Sequence[Finding],
    grown: Finding,
    part: Segments,
) -> list[Finding]:
    """Return findings without some, and a grown term tuned again; none if that loses too much."""
    rest = excluding(findings, grown, *dropped)
    shape = shape_of(grown.candidate)
    if shape is None or any(is_needed(f, (*rest, grown)) for f in dropped):
        return []
    design = with_columns(declared, rest)
    free = replace(grown.candidate, parents=(), shape=shape)
    candidate = replace(grown.candidate, terms=tuned(free, design, part).terms)
    refitted = grown.with_candidate(candidate, design)
    loss = _loss(design, [*dropped, grown], [refitted], part)
    if loss >= MIN_GAIN_LOG * len(dropped):
        return []
    return [refitted if f is grown else f for f in findings if f not in dropped]


def _loss(design: Design, many: Sequence[Finding], few: Sequence[Finding], part: Segments) -> float:
    """Return log(error with few / error with many), each fold predicted from the others."""
    sides = [[column for f in side for column in f.columns] for side in (few, many)]
    grams = spectral_grams(part, design, [*design.columns, *sides[0], *sides[1]])
    fixed, first = len(design.columns), len(design.columns) + len(sides[0])
    models = [range(first), [*range(fixed), *range(first, first + len(sides[1]))]]
    errors = [fold_errors(grams, np.array([list(m)]), part.folds).sum() for m in models]
    return float(np.log(errors[0] / errors[1]))
