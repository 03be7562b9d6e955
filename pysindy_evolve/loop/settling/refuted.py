"""Alternatives that free runs refute.

What tells a friction from a drag in a free decay happens in its first moments, on too few pieces of
the derivative for a test by signs. But where the runs of a model miss a record by little more than
the noise of its sensors, a model whose runs miss it by much more is not the cause.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from ...signals import Record
from ..evidence.findings import Finding, excluding
from ..fitting.trial import converged
from ..free_runs.contenders import steady_drift, trial_with
from ..free_runs.judging import MAX_SQUARES_OVER_NOISE, model_of, over_noise
from ..free_runs.shape_tuning import Contender, tuned_by_runs
from ..given.design import Design

__all__ = ["without_refuted_rivals"]

MAX_SQUARES_RATIO = 2.0  # times the squares that the runs of an effect miss


def without_refuted_rivals(
    declared: Design, findings: Sequence[Finding], records: Sequence[Record]
) -> list[Finding]:
    """Return findings with the alternatives only that runs do not refute.

    Parameters
    ----------
    declared : Design
        The model at the start.
    findings : sequence of Finding
        What was found, with its rivals.
    records : sequence of Record
        Training records, without memories.

    Returns
    -------
    list of Finding
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
    rivals = [rival.candidate for rival in finding.rivals]
    started = [trial_with(rest, [rival], drift) for rival in rivals]
    own, *trials = converged([drift.trial, *started])
    fitted = [Contender(rival, trial) for rival, trial in zip(rivals, trials, strict=True)]
    tuned = tuned_by_runs(fitted, rest, drift)
    pairs = zip(finding.rivals, tuned, strict=True)
    kept = [rival for rival, one in pairs if one.error <= MAX_SQUARES_RATIO * own.error]
    return replace(finding, rivals=tuple(kept))
