"""Findings: effects that passed, with their evidence, and the model with them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ...hidden_states.memory import Memory
from ..effects.candidate import Candidate
from ..given.design import Column, Design
from ..given.limits import Limit, limited
from .rivals import Rival
from .scoring import columns_of


@dataclass(frozen=True, eq=False)
class Finding:
    """An effect that passed, with its evidence.

    Attributes
    ----------
    candidate : Candidate
        Name, equation, terms.
    columns : tuple of Column
        Its columns in the design.
    score : float
        Log ratio of the errors without and with it, per effect of its group.
    p_value : float
        Chance that a twin shows a score as large.
    twin_scores : ndarray
        Best score found in each twin.
    step : int
        Number of the step that found it; the effects of a pair share one.
    rivals : tuple of Rival
        Effects that this data cannot tell from it, once all are found.
    contested : bool
        Whether other effects were tried in its place, once all were found.
    by_runs : bool
        Whether free runs showed it, and not the derivative.
    together : tuple of str
        Names of what it forms together with another effect of its equation.
    """

    candidate: Candidate
    columns: tuple[Column, ...]
    score: float
    p_value: float
    twin_scores: np.ndarray
    step: int = 0
    rivals: tuple[Rival, ...] = ()
    contested: bool = False
    by_runs: bool = False
    together: tuple[str, ...] = ()

    def with_candidate(self, candidate: Candidate, design: Design) -> Finding:
        """Return the same evidence for another effect, with its columns in a design."""
        return replace(self, candidate=candidate, columns=columns_of(candidate, design))


@dataclass(frozen=True, eq=False)
class MemoryFinding(Finding):
    """A memory of an input that passed. It changes the records and adds no column.

    Attributes
    ----------
    memory : Memory
        What the input goes through.
    interval : tuple of float, optional
        95 % interval of its first number, once that is polished, see fine_tuning.py.
    """

    memory: Memory = field(kw_only=True)
    interval: tuple[float, float] | None = field(default=None, kw_only=True)


@dataclass(frozen=True, eq=False)
class LimitFinding(Finding):
    """A limit of a state that passed. It adds no column: its term has no free coefficient."""

    limit: Limit = field(kw_only=True)


@dataclass(frozen=True, eq=False)
class SensorFinding(Finding):
    """An end of the range of a sensor. It changes what is read of a state, but no equation."""

    limit: Limit = field(kw_only=True)


def memories_in(findings: Iterable[Finding]) -> tuple[Memory, ...]:
    """Return the memories among findings, in the order in which they are applied."""
    return tuple(f.memory for f in findings if isinstance(f, MemoryFinding))


def limits_in(findings: Iterable[Finding]) -> tuple[Limit, ...]:
    """Return the limits among findings at which states stop."""
    return tuple(f.limit for f in findings if isinstance(f, LimitFinding))


def at_numbers(finding: Finding, values: Sequence[float], design: Design) -> Finding:
    """Return a finding with other numbers in the shape of its effect."""
    return finding.with_candidate(finding.candidate.at(values), design)


def with_columns(design: Design, findings: Iterable[Finding]) -> Design:
    """Return a design with the columns of findings at its end."""
    return design.adding(column for finding in findings for column in finding.columns)


def with_findings(declared: Design, findings: Sequence[Finding]) -> Design:
    """Return a design with the columns and limits of findings."""
    return limited(with_columns(declared, findings), limits_in(findings))


def excluding(findings: Iterable[Finding], *gone: Finding) -> list[Finding]:
    """Return findings without some of them."""
    return [finding for finding in findings if finding not in gone]


def is_needed(finding: Finding, findings: Iterable[Finding]) -> bool:
    """Tell whether others of its equation have a term of a finding as a parent."""
    terms, state = set(finding.candidate.terms), finding.candidate.state
    others = (f for f in findings if f is not finding and f.candidate.state == state)
    return any(terms & set(other.candidate.parents) for other in others)


def next_step(findings: Iterable[Finding]) -> int:
    """Return the number of the step that comes after findings."""
    return 1 + max((finding.step for finding in findings), default=0)
