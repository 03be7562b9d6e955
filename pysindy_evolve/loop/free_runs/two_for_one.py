"""Two effects in place of one that resembles both together.

Drag and friction together brake a swing much as a cube of the speed does. A search for one effect
at a time finds the cube first, as it explains more than either of the two; beside it, neither of
them seems to be missing. So each effect is compared with the best pairs of named effects. A pair
replaces it if it explains as much of the derivative, and if its runs are closer to the record. To
replace a grown term that is no shorter, the runs of the pair need only be as close.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import takewhile

from ...signals import Record
from ..effects.candidate import Candidate
from ..effects.missing import candidates
from ..effects.names import EVOLVED
from ..evidence.findings import Finding, excluding, is_needed, with_columns
from ..evidence.plainest import is_as_good
from ..evidence.scoring import MIN_GAIN_LOG, score
from ..fitting.trial import converged
from ..given.design import Design
from ..given.rows import have_values
from ..given.rules import Rules
from ..given.segments import Segments
from .contenders import steady_drift, trial_with
from .one_for_one import is_closer
from .variants import Model

N_PAIRS = 3


def two_for_one(
    model: Model,
    findings: Sequence[Finding],
    records: Sequence[Record],
    part: Segments,
    rules: Rules,
) -> list[Finding]:
    """Return the findings, effects replaced by two named ones where these do better.

    Parameters
    ----------
    model : Model
        The declared model, with the memories and limits among the findings.
    findings : sequence of Finding
        What was found.
    records : sequence of Record
        Training records, before memories are applied.
    part : Segments
        Pieces of the records that were searched.
    rules : Rules
        Significance, and the largest number of effects.

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


def _best_pairs(design: Design, present: Candidate, part: Segments) -> list[tuple[Candidate, ...]]:
    """Return the best few pairs of named effects that explain no less than the present effect.

    The list ends before a pair that holds the effect itself: then only its partner was missing.
    """
    offered = [c for c in candidates(design, part.ranges) if c.state == present.state]
    scores = score(design, part, list(dict.fromkeys([*offered, present])), pairs=True)
    alone = max((s.value for s in scores if s.group == (present,)), default=0.0)
    pairs = [s for s in scores if len(s.group) == 2 and 2.0 * s.value > alone - MIN_GAIN_LOG]
    best = sorted(pairs, key=lambda s: -s.value)[:N_PAIRS]
    return [s.group for s in takewhile(lambda s: present not in s.group, best)]


def _closest(
    model: Model,
    finding: Finding,
    pairs: Sequence[tuple[Candidate, ...]],
    records: Sequence[Record],
    rules: Rules,
) -> tuple[Candidate, ...]:
    """Return the pair whose runs come closest to the record; () if the effect is to stay."""
    acted = model.acted(records)
    pairs = [pair for pair in pairs if all(have_values(one.terms, acted) for one in pair)]
    drift = steady_drift(model, [finding.candidate], records) if pairs else None
    if drift is None:
        return ()
    started = [trial_with(model, pair, drift) for pair in pairs]
    present, *of_pairs = converged([drift.trial, *started])
    best = min(range(len(pairs)), key=lambda k: of_pairs[k].error)
    effect, size = finding.candidate, sum(candidate.size for candidate in pairs[best])
    if effect.name == EVOLVED and size <= effect.size:
        is_better = is_as_good(of_pairs[best].error, present.error)
    else:
        is_better = is_closer(of_pairs[best], present, rules.notable_gain, rules.significance)
    return pairs[best] if is_better else ()
