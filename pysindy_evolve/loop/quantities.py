"""Numbers of effects that multiply nothing: delays, time constants, brims, limits."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..hidden import with_memories
from ..signals import Record
from .by_runs import LimitFinding
from .design import Design
from .effect import Effect, Errors
from .recall import MemoryFinding, memories_of, memory_interval
from .step import Finding
from .tuning import intervals_by_runs
from .variants import Model

__all__ = ["with_intervals", "with_limit", "with_memory", "with_share_of_runs"]


def with_share_of_runs(effect: Effect, finding: Finding, before: Errors, after: Errors) -> Effect:
    """Return an effect whose share is that of the error of the free runs."""
    state = finding.candidate.state
    ratio = after.simulation_error[state] / max(before.simulation_error[state], 1e-300)
    return replace(effect, explained=float(1.0 - ratio**2), by_runs=True)


def with_limit(effect: Effect, finding: LimitFinding, train: Sequence[Record]) -> Effect:
    """Return the effect of a limit, which is known as well as the sensor reads it."""
    limit = finding.limit
    noise = max(float(r.preparation.noise[limit.state]) for r in train if r.preparation)
    ends = limit.value + 1.96 * noise * np.array([-1.0, 1.0])
    side = "largest value" if limit.upper else "smallest value"
    return replace(
        effect,
        coefficients=np.array([limit.value]),
        confidence_intervals=ends[None, :],
        quantities=(f"{side} of {effect.state}",),
    )


def with_intervals(
    effects: list[Effect],
    findings: Sequence[Finding],
    design: Design,
    coef: np.ndarray,
    train: Sequence[Record],
    rng: np.random.Generator,
) -> list[Effect]:
    """Return effects, the numbers of memories with intervals that free runs give."""
    model = Model(design, memories_of(findings))
    intervals = iter(intervals_by_runs(model, coef, train, rng)[len(coef) :])
    found = list(effects)
    for k, finding in enumerate(findings):
        if isinstance(finding, MemoryFinding):
            values = finding.memory.values
            ends = np.array([next(intervals) if value else np.zeros(2) for value in values])
            if finding.by_runs:
                found[k] = replace(found[k], confidence_intervals=ends)
    return found


def with_memory(
    effect: Effect,
    finding: MemoryFinding,
    design: Design,
    coef: np.ndarray,
    train: Sequence[Record],
    rng: np.random.Generator,
) -> Effect:
    """Return the effect of a memory with its delay or time constant."""
    memory = finding.memory
    intervals = np.full((len(memory.values), 2), np.nan)
    if not finding.by_runs:
        intervals[0] = memory_interval(memory, design, coef, train, rng)
    equations = with_memories(design.equations(coef), [memory])
    place = len(equations.states) + memory.column
    hidden = len(design.states)
    term = equations.symbols[hidden if memory.has_state else place]
    return replace(
        effect,
        term=term,
        coefficients=np.array(memory.values),
        confidence_intervals=intervals,
        memory=memory,
        quantities=memory.quantities,
    )
