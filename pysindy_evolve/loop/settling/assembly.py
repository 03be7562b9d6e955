"""From what was found to the report of it: each effect with its numbers, errors after each step."""

from __future__ import annotations

from collections.abc import Sequence, Set
from dataclasses import dataclass, replace
from itertools import groupby
from typing import Any

import numpy as np

from ...checks import TINY
from ...export import format_expression
from ...export.compact import as_written
from ...hidden_states.memory import Memory, remembered
from ...signals import Record
from ...terms import Sum, mul
from ..effects.candidate import OFFSET
from ..effects.entries import AS_INPUT, entered
from ..effects.names import INERTIA
from ..evidence.findings import (
    Finding,
    LimitFinding,
    MemoryFinding,
    SensorFinding,
    memories_in,
    with_findings,
)
from ..evidence.rivals import Rival
from ..evidence.scoring import columns_of
from ..fitting.fit import Fit, derivative_fit_errors, refit
from ..given.design import Design
from ..given.rules import Rules
from ..report.effect import Alternative, Effect, Errors, Step
from ..report.report import LoopReport
from ..report.unidentified import unidentified
from .judge import judge
from .quantities import (
    with_intervals,
    with_limit,
    with_memory,
    with_sensor,
    with_share_of_runs,
)

__all__ = ["make_report"]


def make_report(
    declared: Design,
    findings: Sequence[Finding],
    train: Sequence[Record],
    test: Sequence[Record],
    verdict: str,
    finished: bool,
    rules: Rules,
    rng: np.random.Generator,
) -> LoopReport:
    """Fit each stage on all training rows and judge it on held-out records."""
    design, lacks_nothing = declared, verdict == "complete"
    fitted, errors = judge(declared, train, test, rules, rng, final=lacks_nothing)
    unknown = {name for group in unidentified(declared, train) for name in group}
    errors = _with_parameters(errors, declared, fitted, unknown, sure=lacks_nothing)
    before, effects, steps, by_runs = errors, [], [], False
    memories: tuple[Memory, ...] = ()
    for _, group in groupby(findings, key=lambda finding: finding.step):
        found = list(group)
        design = with_findings(design, found)
        last = found[-1] is findings[-1]
        memories += memories_in(found)
        by_runs = by_runs or any(f.by_runs and not f.columns for f in found)
        earlier = errors
        fitted, errors = judge(
            design, train, test, rules, rng, memories, final=last, by_runs=by_runs
        )
        sure = last and not (by_runs and memories)
        errors = _with_parameters(errors, declared, fitted, unknown, sure=sure)
        for finding in found:
            effects.append(_effect(design, finding, train, test, memories))
            if finding.by_runs:
                effects[-1] = with_share_of_runs(effects[-1], finding, earlier, errors)
            steps.append(Step(finding.candidate.name, effects[-1].state, errors))
    corrected = _Corrected(design, fitted, errors, memories, train, test, rng)
    place = len(declared.columns)
    for k, finding in enumerate(findings):
        effects[k] = corrected.numbered(effects[k], finding, place)
        place += len(finding.columns)
    if by_runs and memories:
        effects = with_intervals(effects, findings, design, fitted.coef, train, rng)
    return LoopReport(
        verdict,
        effects,
        before,
        after=errors,
        steps=steps,
        train=tuple(train),
        test=tuple(test),
        finished=finished,
        rules=rules,
        design=design,
    )


@dataclass(frozen=True, eq=False)
class _Corrected:
    """The corrected model, which gives each effect its numbers."""

    design: Design
    fitted: Fit
    errors: Errors
    memories: tuple[Memory, ...]
    train: Sequence[Record]
    test: Sequence[Record]
    rng: np.random.Generator

    def numbered(self, effect: Effect, finding: Finding, place: int) -> Effect:
        """Return an effect, whose columns begin at a place, with its numbers and intervals."""
        design, coef = self.design, self.fitted.coef
        own = slice(place, place + len(finding.columns))
        effect = replace(
            effect, coefficients=coef[own], confidence_intervals=self.fitted.intervals[own]
        )
        if isinstance(finding, MemoryFinding):
            return with_memory(effect, finding, design, coef, self.train, self.rng)
        if isinstance(finding, LimitFinding):
            return with_limit(effect, finding, self.train)
        if isinstance(finding, SensorFinding):
            return with_sensor(effect, finding, self.errors.model, self.test)
        acted = [remembered(record, self.memories) for record in self.train]
        return _with_rivals(effect, finding, design, acted, self.fitted)


def _with_rivals(
    effect: Effect, finding: Finding, design: Design, acted: Sequence[Record], fitted: Fit
) -> Effect:
    """Return an effect whose alternatives have the coefficients that they would have."""
    symbols, rivals = design.symbols, []
    for shown, rival in zip(effect.rivals, finding.rivals, strict=True):
        coef = _in_its_place(design, finding, rival, acted, fitted)
        force = _total(shown.expressions, symbols, coef)
        rivals.append(replace(shown, coefficients=coef, force=force))
    return replace(effect, rivals=tuple(rivals))


def _with_parameters(
    errors: Errors, declared: Design, fitted: Fit, unknown: Set[str], *, sure: bool = False
) -> Errors:
    """Return errors with the declared parameters, which are the first columns of every design.

    Unless records do not tell them, final ones have intervals.
    """
    names = [column.name for column in declared.columns]
    values = {name: float(c) for name, c in zip(names, fitted.coef, strict=False)}
    pairs = zip(names, fitted.intervals, strict=False) if sure else ()
    intervals = {name: interval for name, interval in pairs if name not in unknown}
    return replace(errors, parameters=values, parameter_intervals=intervals)


def _effect(
    design: Design,
    finding: Finding,
    train: Sequence[Record],
    test: Sequence[Record],
    memories: Sequence[Memory],
) -> Effect:
    """Return an effect with its evidence; its coefficients are those of the final model."""
    others = [memory for memory in memories if memory not in memories_in([finding])]
    state, terms = finding.candidate.state, finding.candidate.terms
    written = tuple(column.inertia.wave for column in finding.columns if column.inertia)
    poorer = design.dropping(finding.columns)
    without, with_it = (
        derivative_fit_errors(d, *([remembered(r, m) for r in rs] for rs in (train, test)))[state]
        for d, m in ((poorer, others), (design, memories))
    )
    unknown = np.full(len(terms), np.nan)
    return Effect(
        name=finding.candidate.name,
        state=design.states[state],
        term=_total(written or terms, design.symbols),
        coefficients=unknown,
        confidence_intervals=np.column_stack([unknown, unknown]),
        explained=float(1.0 - (with_it / max(without, TINY)) ** 2),
        p_value=finding.p_value,
        alternatives=(*_other_names(finding), *finding.together),
        together=finding.together,
        contested=finding.contested,
        rivals=tuple(_alternative(rival, design) for rival in finding.rivals),
        expressions=terms,
        twin_scores=finding.twin_scores,
        score=finding.score,
        entry=_entry(poorer, finding),
        written=written,
    )


def _entry(design: Design, finding: Finding) -> str:
    """Say where an effect acts, if it enters its equation as a declared force does."""
    terms, state = finding.candidate.terms, finding.candidate.state
    if finding.candidate.name == INERTIA:
        return "in the inertia, whose mean counts as one and divides all forces"
    place = entered(design, state, terms[0]) if len(terms) == 1 and finding.columns else None
    if place is None:
        return ""
    entry, force = place
    name = design.names[entry.beside]
    if entry.beside < len(design.states):
        return f"through the same factor as the damping of {name}"
    if mul(entry.factor, force) != terms[0] or not entry.is_known:
        return f"through the same factor as {name}"
    number = f"{AS_INPUT} {name} were larger by this number"
    if force == OFFSET:
        return number
    return f"{number} times {format_expression(force.to_sympy(design.symbols))}"


def _total(
    terms: Sequence[Sum], symbols: Sequence[Any], coef: Sequence[float] | np.ndarray = ()
) -> Any:
    """Return the sum of terms in sympy, each times its coefficient where these are known."""
    factors = coef if len(coef) else [1] * len(terms)
    pairs = zip(factors, terms, strict=True)
    return sum(factor * as_written(term, symbols) for factor, term in pairs)


def _other_names(finding: Finding) -> tuple[str, ...]:
    return tuple(r.name for r in finding.rivals if r.name != finding.candidate.name)


def _alternative(rival: Rival, design: Design) -> Alternative:
    candidate, state = rival.candidate, design.states[rival.candidate.state]
    term = _total(candidate.terms, design.symbols)
    return Alternative(candidate.name, state, term, rival.p_value, candidate.terms, force=term)


def _in_its_place(
    design: Design, finding: Finding, rival: Rival, records: Sequence[Record], fitted: Fit
) -> np.ndarray:
    """Return the coefficients of a rival in the place of what was found."""
    columns = columns_of(rival.candidate, design)
    other = design.dropping(finding.columns).adding(columns)
    return refit(other, records, fitted.criterion)[-len(columns) :]
