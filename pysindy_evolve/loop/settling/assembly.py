"""From what was found to the outcome: each effect with its numbers, errors after each step."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from ...hidden_states.memory import all_with_memories
from ...signals import Record
from ..effects.periodic import frequency_of
from ..evidence.findings import Finding, LimitFinding, MemoryFinding, SensorFinding
from ..evidence.rivals import Rival
from ..evidence.scoring import columns_of
from ..facts.effect import Effect, Step
from ..facts.outcome import Outcome
from ..fitting.fit import refit
from ..given.held import held_like
from ..given.resampling import widened
from ..search.found import Found
from .descriptions import described, total
from .quantities import with_intervals, with_limit, with_memory, with_sensor, with_share_of_runs
from .stages import Stage, fitted_stages

FLAT_CUTOFF_SHARE = 0.5  # of the cutoff, up to which a low-pass leaves what there is


def assembled(
    found: Found,
    findings: Sequence[Finding],
    test: Sequence[Record],
    rng: np.random.Generator,
    *,
    finished: bool,
) -> Outcome:
    """Fit all stages and judge them, on records whose low-pass leaves what was found.

    `findings` are those of `found` under their right names, with their alternatives.
    """
    declared, verdict = found.declared, found.verdict
    train, judged = found.records, [held_like(record, found.records) for record in test]
    if not declared.algebraic and _is_near_cutoff(findings, found.records):
        train, judged = found.wide_records, widened(judged)
    stages = fitted_stages(found, findings, train, judged, rng)
    first, last = stages[0], stages[-1]
    effects = _described(stages, train, judged)
    steps = [
        Step(finding.candidate.name, declared.states[finding.candidate.state], stage.errors)
        for stage in stages
        for finding in stage.new
    ]
    return Outcome(
        verdict,
        _numbered(effects, stages, train, judged, rng),
        before=first.errors,
        after=last.errors,
        steps=steps,
        train=tuple(train),
        test=tuple(judged),
        finished=finished,
        rules=found.rules,
        design=last.design,
        rejected=found.rejected,
        chance_left=found.chance_left,
        found_held=tuple(sorted(set(found.held) - set(test[0].held))),
    )


def _is_near_cutoff(findings: Sequence[Finding], records: Sequence[Record]) -> bool:
    """Tell whether the low-pass of records takes a part of a forcing: its size would be too small.

    It is a function of time, not of what was measured, so it did not pass the same filter.
    """
    cutoff = min((record.cutoff for record in records if record.cutoff), default=np.inf)
    return any(frequency_of(finding.candidate) > FLAT_CUTOFF_SHARE * cutoff for finding in findings)


def _described(
    stages: Sequence[Stage], train: Sequence[Record], test: Sequence[Record]
) -> list[Effect]:
    """Return the effects of all stages, each with what it explains there."""
    effects = []
    for before, stage in pairwise(stages):
        for finding in stage.new:
            effect = described(finding, stage, train, test)
            if finding.by_runs:
                effect = with_share_of_runs(effect, finding, before.errors, stage.errors)
            effects.append(effect)
    return effects


def _numbered(
    effects: Sequence[Effect],
    stages: Sequence[Stage],
    train: Sequence[Record],
    test: Sequence[Record],
    rng: np.random.Generator,
) -> list[Effect]:
    """Return effects with the numbers of the corrected model, whose last columns are theirs."""
    first, last = stages[0], stages[-1]
    coef, intervals, numbered = last.fitted.coef, last.fitted.intervals, []
    place = len(first.design.columns)
    for effect, finding in zip(effects, last.findings, strict=True):
        own = slice(place, place + len(finding.columns))
        place = own.stop
        effect = replace(effect, coefficients=coef[own], confidence_intervals=intervals[own])
        if isinstance(finding, MemoryFinding):
            effect = with_memory(effect, finding, last, train, rng)
        elif isinstance(finding, LimitFinding):
            effect = with_limit(effect, finding, train)
        elif isinstance(finding, SensorFinding):
            effect = with_sensor(effect, finding, last.errors.model, test)
        else:
            effect = _with_rivals(effect, finding, last, train)
        numbered.append(effect)
    return with_intervals(numbered, last, train, rng) if last.has_memories_of_runs else numbered


def _with_rivals(effect: Effect, finding: Finding, last: Stage, train: Sequence[Record]) -> Effect:
    """Return an effect whose alternatives have the coefficients that they would have."""
    acted = all_with_memories(train, last.memories)
    rivals = []
    for shown, rival in zip(effect.rivals, finding.rivals, strict=True):
        coef = _in_its_place(finding, rival, last, acted)
        force = total(shown.expressions, last.design.symbols, coef)
        rivals.append(replace(shown, coefficients=coef, force=force))
    return replace(effect, rivals=tuple(rivals))


def _in_its_place(
    finding: Finding, rival: Rival, last: Stage, records: Sequence[Record]
) -> np.ndarray:
    """Return the coefficients of a rival in the place of what was found."""
    columns = columns_of(rival.candidate, last.design)
    other = last.design.dropping(finding.columns).adding(columns)
    return refit(other, records, last.fitted.criterion)[-len(columns) :]
