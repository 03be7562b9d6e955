"""Drop memories, and findings of free runs, once later effects explain them.

A missing cosine of the input makes runs leave the record much as a delay of the input does.
"""

from __future__ import annotations

from collections.abc import Sequence

from ...hidden_states.memory import all_with_memories
from ...signals import Record
from ..evidence.findings import Finding, LimitFinding, MemoryFinding, excluding, is_needed
from ..evidence.scoring import MIN_GAIN_LOG
from ..fitting.fit import derivative_square, refit
from ..fitting.linear import log_ratio
from ..fitting.trial import converged
from ..free_runs.drift import drift_of
from ..free_runs.judging import model_of
from ..free_runs.variants import Model
from ..given.design import Design


def without_superseded(
    declared: Design, findings: Sequence[Finding], records: Sequence[Record], wide: Sequence[Record]
) -> list[Finding]:
    """Return findings without those that neither the derivative nor free runs need any longer.

    Parameters
    ----------
    declared : Design
        The declared model.
    findings : sequence of Finding
        What was found.
    records : sequence of Record
        Training records, before memories are applied.
    wide : sequence of Record
        The same with a higher cutoff, for the derivative.

    Returns
    -------
    list of Finding
    """
    for finding in findings:
        rest = excluding(findings, finding)
        if _may_be_superseded(finding, rest):
            sides = model_of(declared, findings), model_of(declared, rest)
            if (
                _derivative_loss(*sides, wide) < MIN_GAIN_LOG
                and _loss_of_runs(*sides, records) < MIN_GAIN_LOG
            ):
                return without_superseded(declared, rest, records, wide)
    return list(findings)


def _may_be_superseded(finding: Finding, rest: Sequence[Finding]) -> bool:
    """Tell whether later effects may explain what a finding did, and none of the rest needs it."""
    hidden = isinstance(finding, MemoryFinding) or finding.by_runs
    followed = any(other.step > finding.step for other in rest)
    is_free = not (is_needed(finding, rest) or isinstance(finding, LimitFinding))
    return hidden and followed and is_free


def _derivative_loss(many: Model, few: Model, wide: Sequence[Record]) -> float:
    """Return log(error of the derivative with few effects / with many)."""
    errors = []
    for model in (many, few):
        acted = all_with_memories(wide, model.memories)
        coef = refit(model.whole, acted, "derivative")
        errors.append(derivative_square(model.whole, acted, coef))
    return log_ratio(errors[1], errors[0])


def _loss_of_runs(many: Model, few: Model, records: Sequence[Record]) -> float:
    """Return log(error of free runs with few effects / with many); infinity if `many` fails."""
    coef = [refit(model.design, model.acted(records), "derivative") for model in (many, few)]
    drift = drift_of(many, coef[0], records)
    if drift is None:
        return float("inf")
    (trial,) = converged([few.trial(coef[1], drift.trial.scale, drift.part)])
    return log_ratio(trial.error, drift.trial.error)
