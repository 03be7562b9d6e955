"""What else could stand in the place of each effect, and which of these is named.

What tells a friction from a drag in a free decay happens in its first moments, on too few pieces of
the derivative for a test by signs. But where the runs of a model miss a record by little more than
the noise of its sensors, a model whose runs miss it by much more is not the cause.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...signals import Record
from ..effects.candidate import OFFSET, Candidate
from ..evidence.findings import Finding, excluding, is_needed, with_columns
from ..evidence.rivals import Rival, rivals_of
from ..fitting.trial import converged
from ..free_runs.contenders import steady_drift, trial_with
from ..free_runs.judging import MAX_SQUARES_OVER_NOISE, model_of, over_noise
from ..free_runs.shape_tuning import Contender, tuned_by_runs
from ..given.design import Design
from ..given.rows import have_values
from ..given.segments import Segments

# Share of the significance at which a rival is refuted. One that stays costs another measurement,
# a cause that is lost a wrong machine: at 5 % for what is named, the cause is kept with 99 %.
REFUTED = 0.2
MAX_SQUARES_RATIO = 2.0  # times the squares that the runs of an effect miss


def with_rivals(
    declared: Design,
    findings: Sequence[Finding],
    part: Segments,
    significance: float,
    rng: np.random.Generator,
    grown: Sequence[Candidate] = (),
) -> list[Finding]:
    """Return findings, each with the effects that could stand in its place beside all the others.

    Of a grown term, others that grew are among them. One that a later effect needs has no rivals:
    both would have to go.
    """
    judged, level = [], REFUTED * significance
    for finding in findings:
        rest = excluding(findings, finding)
        design = with_columns(declared, rest)
        if finding.columns and not is_needed(finding, rest):
            found = rivals_of(finding.candidate, design, part, level, rng, grown)
            finding = replace(finding, rivals=found, contested=True)
            if part.by_trajectory:
                finding = with_plainest_effect(finding, design, significance)
        judged.append(finding)
    return judged


def with_plainest_effect(finding: Finding, design: Design, significance: float) -> Finding:
    """Return a finding with the plainest effect that the record allows in its place.

    On a short trajectory most things change with each other and with the time. What depends on the
    time says nothing about the next record, and what depends on several states is bent by how they
    happened to move together, so either is named only where it has to be. A constant takes no
    place: it absorbs a part of whatever there is.
    """

    def burden(candidate: Candidate) -> tuple[bool, int]:
        return design.time in candidate.variables, len(candidate.variables)

    likely = [r for r in finding.rivals if r.p_value > significance]
    bending = [r for r in likely if OFFSET not in r.candidate.terms]
    able = [r for r in bending if burden(r.candidate) < burden(finding.candidate)]
    if not able:
        return finding
    best = min(able, key=lambda rival: (burden(rival.candidate), -rival.p_value))
    rivals = (Rival(finding.candidate, 1.0), *(r for r in finding.rivals if r is not best))
    return replace(finding.with_candidate(best.candidate, design), rivals=rivals)


def without_refuted_rivals(
    declared: Design, findings: Sequence[Finding], records: Sequence[Record]
) -> list[Finding]:
    """Return findings with the alternatives only that runs over records do not refute.

    An alternative without a value on a row, such as the root of a negative number, is none.
    """
    return [_without_refuted_rivals(declared, findings, one, records) for one in findings]


def _without_refuted_rivals(
    declared: Design, findings: Sequence[Finding], finding: Finding, records: Sequence[Record]
) -> Finding:
    if not finding.rivals:
        return finding
    rest = model_of(declared, excluding(findings, finding))
    drift = steady_drift(rest, [finding.candidate], records)
    if drift is None or over_noise(drift) > MAX_SQUARES_OVER_NOISE:
        return finding
    acted = rest.acted(records)
    offered = [one for one in finding.rivals if have_values(one.candidate.terms, acted)]
    rivals = [rival.candidate for rival in offered]
    started = [trial_with(rest, [rival], drift) for rival in rivals]
    own, *trials = converged([drift.trial, *started])
    fitted = [Contender(rival, trial) for rival, trial in zip(rivals, trials, strict=True)]
    tuned = tuned_by_runs(fitted, rest, drift)
    pairs = zip(offered, tuned, strict=True)
    kept = [rival for rival, one in pairs if one.error <= MAX_SQUARES_RATIO * own.error]
    return replace(finding, rivals=tuple(kept))
