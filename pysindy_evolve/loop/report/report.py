"""What the loop found: the equations and errors before and after, and each effect's evidence."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np
import pysindy as ps

from ...equations import Equations
from ...hidden_states.hidden import MemoryEquations
from ...hidden_states.memory import Memory, remembered
from ...signals import Record
from ...terms import Sum
from ..evidence.rejected import Rejected
from ..evidence.rivals import Rival
from ..evidence.scoring import columns_of
from ..evidence.step import Finding
from ..fitting.fit import Fit, derivative_fit_errors, refit
from ..fitting.past import rates_on
from ..fitting.runs import free_run
from ..free_runs.by_runs import with_findings
from ..free_runs.clipped import SensorFinding
from ..free_runs.halts import LimitFinding
from ..given.design import Design
from ..given.rules import Rules
from ..given.sensor import heard
from ..memories.recall import MemoryFinding, memories_of
from .effect import Alternative, Effect, Errors, Step
from .experiment import Plan, plan
from .judge import judge
from .model import as_sindy
from .quantities import (
    as_read,
    with_intervals,
    with_limit,
    with_memory,
    with_sensor,
    with_share_of_runs,
)
from .text import as_markdown, as_text

__all__ = ["Effect", "Errors", "LoopReport", "Step", "make_report"]


@dataclass(frozen=True, eq=False)
class LoopReport:
    """What a declared model lacks, and what it is worth to add it.

    Attributes
    ----------
    verdict : {"complete", "traced", "untraced"}
        Nothing missing that the data can show; effects found and added; or structure remains that
        no tried effect explains.
    effects : list of Effect
        What was added, in the order of its finding.
    before, after : Errors
        Errors of the declared and of the corrected model on held-out data.
    steps : list of Step
        Errors after each effect.
    train, test : tuple of Record
        The records.
    finished : bool
        False if the search was interrupted or ran into `max_effects`.
    rejected : Rejected, optional
        The best of what was tried last and did not pass; None if nothing was left to try.
    rules : Rules, optional
        The settings.
    design : Design, optional
        The corrected model with its coefficients free.
    """

    verdict: str
    effects: list[Effect]
    before: Errors
    after: Errors
    steps: list[Step]
    train: tuple[Record, ...]
    test: tuple[Record, ...]
    finished: bool
    rejected: Rejected | None = None
    rules: Rules | None = None
    design: Design | None = None

    @property
    def equations(self) -> Equations:
        """The corrected model."""
        return self.after.model

    @cached_property
    def model(self) -> ps.SINDy:
        """The corrected model as a fitted SINDy model; time, if needed, is its last input."""
        return as_sindy(self.equations)

    @property
    def residual_before(self) -> list[np.ndarray]:
        """x_dot minus the declared model, for each held-out record; zero where nobody saw it."""
        return [_residual(self.before.model, record) for record in self.test]

    @property
    def residual_after(self) -> list[np.ndarray]:
        """x_dot minus the corrected model, for each held-out record; zero where nobody saw it."""
        return [_residual(self.after.model, record) for record in self.test]

    def simulate(self, record: Record) -> np.ndarray:
        """Run the corrected model freely over a record.

        Parameters
        ----------
        record : Record
            Supplies the times, the first state and the inputs.

        Returns
        -------
        ndarray of shape (n_samples, n_states)
            As the sensors show them, where one of the effects is that a sensor clips.
        """
        run = free_run(self.equations, record)
        return as_read(run, self.equations.states, self.effects)

    def __str__(self) -> str:
        return as_text(self)

    def to_markdown(self) -> str:
        """Return the report as Markdown: what is printed, the twins, and what to measure next."""
        return as_markdown(self)

    def to_html(self, path: str | Path, units: Mapping[str, str] | None = None) -> None:
        """Write the report with its pictures as one page of HTML that needs nothing else.

        Parameters
        ----------
        path : str or Path
            File to write; folders that are missing are made.
        units : mapping of str to str, optional
            Units of the variables and of t, for the labels: ``{"q": "m", "t": "s"}``.
        """
        from .html import as_html

        page, file = as_html(self, units), Path(path)
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(page, encoding="utf-8")

    def suggest_experiment(self, units: Mapping[str, str] | None = None) -> Plan:
        """Say what to measure next, so that effects and their alternatives come apart.

        Parameters
        ----------
        units : mapping of str to str, optional
            Units of the variables: ``{"q": "m", "v": "m/s"}``.

        Returns
        -------
        Plan
            One experiment for each pair: the recorded motion with another amplitude or at other
            frequencies. Prints as sentences.
        """
        return plan(self, units)

    def plot(self, state: str | None = None, units: Mapping[str, str] | None = None) -> Any:
        """Draw where the held-out residual lives, before and after.

        Over time, over frequency, over the variables that matter, and in the phase plane.

        Parameters
        ----------
        state : str, optional
            Equation to draw; by default the one that the first effect entered.
        units : mapping of str to str, optional
            Units of the variables and of t, for the labels: ``{"q": "m", "t": "s"}``.

        Returns
        -------
        matplotlib.figure.Figure
        """
        from .plot import plot_residuals

        return plot_residuals(self, state, units)


def _residual(equations: Equations, record: Record) -> np.ndarray:
    if isinstance(equations, MemoryEquations):
        record, equations = remembered(record, equations.memories), equations.inner
    return heard(record, record.x_dot - rates_on(equations, record))


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
    design = declared
    fitted, errors = judge(declared, train, test, rules, rng)
    errors = replace(errors, parameters=_parameters(declared, fitted.coef))
    before, effects, steps, by_runs = errors, [], [], False
    memories: tuple[Memory, ...] = ()
    for _, group in groupby(findings, key=lambda finding: finding.step):
        found = list(group)
        design = with_findings(design, found)
        last = found[-1] is findings[-1]
        memories += memories_of(found)
        by_runs = by_runs or any(finding.by_runs for finding in found)
        earlier = errors
        fitted, errors = judge(
            design, train, test, rules, rng, memories, final=last, by_runs=by_runs
        )
        errors = replace(errors, parameters=_parameters(declared, fitted.coef))
        for finding in found:
            effects.append(_effect(design, finding, train, test, memories))
            if finding.by_runs:
                effects[-1] = with_share_of_runs(effects[-1], finding, earlier, errors)
            steps.append(Step(finding.candidate.name, effects[-1].state, errors))
    place = len(declared.columns)
    for k, finding in enumerate(findings):
        own = slice(place, place + len(finding.columns))
        place = own.stop
        effects[k] = replace(
            effects[k], coefficients=fitted.coef[own], confidence_intervals=fitted.intervals[own]
        )
        if isinstance(finding, MemoryFinding):
            effects[k] = with_memory(effects[k], finding, design, fitted.coef, train, rng)
        elif isinstance(finding, LimitFinding):
            effects[k] = with_limit(effects[k], finding, train)
        elif isinstance(finding, SensorFinding):
            effects[k] = with_sensor(effects[k], finding, errors.model, test)
        else:
            acted = [remembered(record, memories) for record in train]
            effects[k] = _with_rivals(effects[k], finding, design, acted, fitted)
    if by_runs and memories:
        effects = with_intervals(effects, findings, design, fitted.coef, train, rng)
    records = tuple(train), tuple(test)
    report = LoopReport(verdict, effects, before, errors, steps, *records, finished)
    return replace(report, rules=rules, design=design)


def _with_rivals(
    effect: Effect, finding: Finding, design: Design, acted: Sequence[Record], fitted: Fit
) -> Effect:
    """Return an effect whose alternatives have the coefficients that they would have."""
    rivals = tuple(
        replace(shown, coefficients=_in_its_place(design, finding, rival, acted, fitted))
        for shown, rival in zip(effect.rivals, finding.rivals, strict=True)
    )
    return replace(effect, rivals=rivals)


def _parameters(declared: Design, coef: np.ndarray) -> dict[str, float]:
    """Return the declared parameters, which are the first columns of every later design, too."""
    return {column.name: float(c) for column, c in zip(declared.columns, coef, strict=False)}


def _effect(
    design: Design,
    finding: Finding,
    train: Sequence[Record],
    test: Sequence[Record],
    memories: Sequence[Memory],
) -> Effect:
    """Return an effect with its evidence; its coefficients are those of the final model."""
    others = [memory for memory in memories if memory not in memories_of([finding])]
    state, terms = finding.candidate.state, finding.candidate.terms
    symbols = design.equations(np.zeros(len(design.columns))).symbols
    poorer = design.dropping(finding.columns)
    without, with_it = (
        derivative_fit_errors(d, *([remembered(r, m) for r in rs] for rs in (train, test)))[state]
        for d, m in ((poorer, others), (design, memories))
    )
    unknown = np.full(len(terms), np.nan)
    return Effect(
        name=finding.candidate.name,
        state=design.states[state],
        term=_total(terms, symbols),
        coefficients=unknown,
        confidence_intervals=np.column_stack([unknown, unknown]),
        explained=float(1.0 - (with_it / max(without, 1e-300)) ** 2),
        p_value=finding.p_value,
        alternatives=_other_names(finding),
        rivals=tuple(_alternative(rival, design) for rival in finding.rivals),
        expressions=terms,
        twin_scores=finding.twin_scores,
        score=finding.score,
    )


def _total(terms: Sequence[Sum], symbols: Sequence[Any]) -> Any:
    return sum((term.to_sympy(symbols) for term in terms[1:]), terms[0].to_sympy(symbols))


def _other_names(finding: Finding) -> tuple[str, ...]:
    return tuple(r.name for r in finding.rivals if r.name != finding.candidate.name)


def _alternative(rival: Rival, design: Design) -> Alternative:
    symbols = design.equations(np.zeros(len(design.columns))).symbols
    candidate = rival.candidate
    term = _total(candidate.terms, symbols)
    state = design.states[candidate.state]
    return Alternative(candidate.name, state, term, rival.p_value, candidate.terms)


def _in_its_place(
    design: Design, finding: Finding, rival: Rival, records: Sequence[Record], fitted: Fit
) -> np.ndarray:
    """Return the coefficients of a rival in the place of what was found."""
    columns = columns_of(rival.candidate, design)
    other = design.dropping(finding.columns).adding(columns)
    return refit(other, records, fitted.criterion)[-len(columns) :]
