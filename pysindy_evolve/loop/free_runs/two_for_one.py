"""Two effects in the place of one that resembles both together.

Drag and friction brake a swing in much the way that a cube of the speed does. Looked for one at a
time, the cube comes first, as it does more than either of the two; and beside it, neither of them
is missed. So each effect is held against the best two names in its place: they take it if they
explain more of the derivative, and if the runs with them come closer to the record. Of a grown term
that is no shorter than both they need not be closer, for engineers know them by their names.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import takewhile

import numpy as np

from ...signals import Record
from ..effects.candidate import Candidate
from ..effects.missing import candidates
from ..effects.names import EVOLVED
from ..evidence.findings import Finding, excluding, is_needed, with_columns
from ..evidence.scoring import MARGIN, score
from ..fitting.trial import converged
from ..given.design import Design
from ..given.rules import Rules
from ..given.segments import Segments
from .comparison import is_closer
from .contenders import begun_with, steady_drift
from .variants import Model

__all__ = ["two_for_one"]

N_PAIRS = 3


def two_for_one(
    model: Model,
    findings: Sequence[Finding],
    records: Sequence[Record],
    part: Segments,
    rules: Rules,
) -> list[Finding]:
    """Return findings in which two names have taken the place of an effect.

    Parameters
    ----------
    model : Model
        The declared model, with the memories and limits among the findings.
    findings : sequence of Finding
        What was found.
    records : sequence of Record
        Training records, without memories.
    part : Segments
        Pieces of them as they were searched.
    rules : Rules
        Significance, and the most effects that there may be.

    Returns
    -------
    list of Finding
    """
    kept = list(findings)
    for finding in findings:
        rest = excluding(kept, finding)
        if not finding.columns or is_needed(finding, rest) or len(rest) + 2 > rules.max_effects:
            continue
        without = replace(model, design=with_columns(model.design, rest))
        pairs = _best_pairs(without.design, finding.candidate, part)
        pair = _closest(without, finding, pairs, records, rules)
        if pair:
            place = kept.index(finding)
            kept[place : place + 1] = [finding.with_candidate(c, without.design) for c in pair]
    return kept


def _best_pairs(design: Design, own: Candidate, part: Segments) -> list[tuple[Candidate, ...]]:
    """Return the few pairs of names that explain most, and no less than an effect does.

    If the effect is itself in the best pair, it is kept: its partner alone was not found.
    """
    offered = [c for c in candidates(design, part.ranges) if c.state == own.state]
    scores = score(design, part, list(dict.fromkeys([*offered, own])), pairs=True)
    alone = max((s.value for s in scores if s.group == (own,)), default=0.0)
    pairs = [s for s in scores if len(s.group) == 2 and 2.0 * s.value > alone - MARGIN]
    best = sorted(pairs, key=lambda s: -s.value)[:N_PAIRS]
    return [s.group for s in takewhile(lambda s: own not in s.group, best)]


def _closest(
    model: Model,
    finding: Finding,
    pairs: Sequence[tuple[Candidate, ...]],
    records: Sequence[Record],
    rules: Rules,
) -> tuple[Candidate, ...]:
    """Return the pair whose runs come closest to the record, if they do better than an effect's."""
    drift = steady_drift(model, [finding.candidate], records) if pairs else None
    if drift is None:
        return ()
    begun = [begun_with(model, pair, drift) for pair in pairs]
    one, *twos = converged([drift.trial, *begun])
    best = min(range(len(pairs)), key=lambda k: twos[k].error)
    own, size = finding.candidate, sum(candidate.size for candidate in pairs[best])
    if own.name == EVOLVED and size <= own.size:
        stands = twos[best].error <= np.exp(MARGIN) * one.error
    else:
        stands = is_closer(twos[best], one, rules.notable_gain, rules.significance)
    return pairs[best] if stands else ()
