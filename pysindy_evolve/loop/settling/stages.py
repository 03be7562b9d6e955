"""The stages from the declared model to the corrected one, each fitted and judged."""

from __future__ import annotations

from collections.abc import Sequence, Set
from dataclasses import dataclass, replace
from itertools import groupby

import numpy as np

from ...hidden_states.memory import Memory
from ...signals import Record
from ..evidence.findings import Finding, memories_in, with_findings
from ..facts.effect import Errors
from ..facts.unidentified import unidentified
from ..fitting.fit import Fit
from ..given.design import Design
from ..search.found import Found
from .judge import judge, needs_runs


@dataclass(frozen=True, eq=False)
class Stage:
    """The model after a step: fitted on all training rows, judged on held-out records.

    Attributes
    ----------
    new : tuple of Finding
        What this step found; nothing in the first stage, which is the declared model.
    findings : tuple of Finding
        All that was found up to this step.
    design : Design
        The model with them.
    fitted : Fit
        Its coefficients.
    errors : Errors
        Its errors.
    """

    new: tuple[Finding, ...]
    findings: tuple[Finding, ...]
    design: Design
    fitted: Fit
    errors: Errors

    @property
    def memories(self) -> tuple[Memory, ...]:
        """What the inputs go through before they act."""
        return memories_in(self.findings)

    @property
    def has_memories_of_runs(self) -> bool:
        """Whether runs tell memories and coefficients together, so that no interval is its own."""
        return needs_runs(self.findings) and bool(self.memories)


def fitted_stages(
    found: Found,
    findings: Sequence[Finding],
    train: Sequence[Record],
    test: Sequence[Record],
    rng: np.random.Generator,
) -> list[Stage]:
    """Fit and judge the declared model, and the model after each step.

    Parameters
    ----------
    found : Found
        What the search found. Where nothing is missing, the declared model is the final one.
    findings : sequence of Finding
        The same findings under their right names, in the order of the steps.
    train, test : sequence of Record
        To fit on, and to judge on.
    rng : numpy.random.Generator
        Source of all randomness.

    Returns
    -------
    list of Stage
        The declared model comes first.
    """
    declared, rules, is_complete = found.declared, found.rules, found.verdict == "complete"
    unknown = {name for group in unidentified(declared, train) for name in group}
    fitted, errors = judge(declared, (), train, test, rules, rng, final=is_complete)
    first = Stage((), (), declared, fitted, errors)
    stages = [_with_parameters(first, declared, unknown, sure=is_complete)]
    for _, group in groupby(findings, key=lambda finding: finding.step):
        new = tuple(group)
        known = (*stages[-1].findings, *new)
        design, is_last = with_findings(stages[-1].design, new), known[-1] is findings[-1]
        fitted, errors = judge(design, known, train, test, rules, rng, final=is_last)
        stage = Stage(new, known, design, fitted, errors)
        # Intervals that take memories as given would be too narrow where runs tell these as well.
        sure = is_last and not stage.has_memories_of_runs
        stages.append(_with_parameters(stage, declared, unknown, sure=sure))
    return stages


def _with_parameters(stage: Stage, declared: Design, unknown: Set[str], *, sure: bool) -> Stage:
    """Return a stage with the declared parameters, which are the first columns of every design.

    Unless records do not tell them, final ones have intervals.
    """
    fitted = stage.fitted
    names = [column.name for column in declared.columns]
    values = {name: float(c) for name, c in zip(names, fitted.coef, strict=False)}
    pairs = zip(names, fitted.intervals, strict=False) if sure else ()
    intervals = {name: interval for name, interval in pairs if name not in unknown}
    errors = replace(stage.errors, parameters=values, parameter_intervals=intervals)
    return replace(stage, errors=errors)
