"""Numbers of effects that multiply nothing: delays, time constants, brims, limits."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import sympy

from ...checks import TINY
from ...equations import Equations
from ...hidden_states.memory_equations import with_memories
from ...signals import Record
from ..evidence.findings import Finding, LimitFinding, MemoryFinding, SensorFinding
from ..facts.effect import Effect, Errors
from ..fitting.runs import free_run
from ..free_runs.memory_tuning import intervals_by_runs
from ..free_runs.variants import Model
from ..given.limits import Limit
from ..given.sensor import limits_of_states, shown
from ..memories.fine_tuning import row_interval
from .stages import Stage


def with_share_of_runs(effect: Effect, finding: Finding, before: Errors, after: Errors) -> Effect:
    """Return an effect whose share is that of the error of the free runs.

    Nothing where the model with it cannot be run over the held-out records.
    """
    state = finding.candidate.state
    error, with_it = (errors.simulation_error[state] for errors in (before, after))
    removed = 1.0 - (with_it / max(error, TINY)) ** 2 if np.isfinite(with_it) else 0.0
    return replace(effect, explained=float(removed), by_runs=True)


def with_limit(effect: Effect, finding: LimitFinding, train: Sequence[Record]) -> Effect:
    """Return the effect of a limit, which is known as well as the sensor reads it."""
    made = [record.preparation for record in train if record.preparation is not None]
    noise = max(float(one.noise[finding.limit.state // one.order]) for one in made)
    return _ending(effect, finding.limit, noise, "value")


def _ending(effect: Effect, limit: Limit, noise: float, what: str) -> Effect:
    ends = limit.value + 1.96 * noise * np.array([-1.0, 1.0])
    side = "largest" if limit.upper else "smallest"
    return replace(
        effect,
        coefficients=np.array([limit.value]),
        confidence_intervals=ends[None, :],
        quantities=(f"{side} {what} of {effect.state}",),
    )


def with_sensor(
    effect: Effect, finding: SensorFinding, equations: Equations, test: Sequence[Record]
) -> Effect:
    """Return the effect of a sensor that clips, whose limit is read without noise.

    Its share is that of the free runs' error, had they been compared with the readings as they are.
    """
    limit = finding.limit
    end = sympy.Min if limit.upper else sympy.Max
    effect = replace(
        _ending(effect, limit, 0.0, "reading"),
        term=end(sympy.Symbol(effect.state, real=True), limit.value),
        of_sensor=True,
        by_runs=True,
    )
    limits, squares = limits_of_states(test), np.zeros(2)
    for record in test:
        run = free_run(equations, record, on_divergence="nan")[:, : record.n_states]
        reading = shown(record.x, limits)[:, limit.state]
        for k, there in enumerate((run, shown(run, limits))):
            squares[k] += np.sum((there[:, limit.state] - reading) ** 2)
    return replace(effect, explained=float(1.0 - squares[1] / max(squares[0], TINY)))


def with_intervals(
    effects: list[Effect], last: Stage, train: Sequence[Record], rng: np.random.Generator
) -> list[Effect]:
    """Return effects, the numbers of memories with intervals that free runs give."""
    model, coef = Model(last.design, last.memories), last.fitted.coef
    intervals = iter(intervals_by_runs(model, coef, train, rng)[len(coef) :])
    found = list(effects)
    for k, finding in enumerate(last.findings):
        if isinstance(finding, MemoryFinding):
            values = finding.memory.values
            ends = np.array([next(intervals) if value else np.zeros(2) for value in values])
            if finding.by_runs:
                found[k] = replace(found[k], confidence_intervals=ends)
    return found


def with_memory(
    effect: Effect,
    finding: MemoryFinding,
    last: Stage,
    train: Sequence[Record],
    rng: np.random.Generator,
) -> Effect:
    """Return the effect of a memory with its delay or time constant."""
    memory, design, coef = finding.memory, last.design, last.fitted.coef
    intervals = np.full((len(memory.values), 2), np.nan)
    if finding.interval is not None:
        intervals[0] = finding.interval
    elif not finding.by_runs:
        intervals[0] = row_interval(memory, design, coef, train, rng)
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
