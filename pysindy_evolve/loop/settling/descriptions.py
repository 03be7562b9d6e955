"""Effects as the report has them: in words, with what they explain, without their numbers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ...checks import TINY
from ...export import format_expression
from ...export.compact import as_written, compact
from ...hidden_states.memory import all_with_memories
from ...signals import Record
from ...terms import Sum, Variable, mul
from ..effects.candidate import OFFSET
from ..effects.entries import AS_INPUT, entered
from ..effects.names import INERTIA, SATURATING
from ..evidence.findings import Finding, memories_in
from ..evidence.rivals import Rival
from ..facts.effect import Alternative, Effect
from ..fitting.fit import derivative_fit_errors
from ..given.design import Design
from .stages import Stage


def described(
    finding: Finding, stage: Stage, train: Sequence[Record], test: Sequence[Record]
) -> Effect:
    """Return an effect with its evidence.

    Parameters
    ----------
    finding : Finding
        What was found.
    stage : Stage
        The model after the step that found it.
    train, test : sequence of Record
        To fit on, and to judge on.

    Returns
    -------
    Effect
        Its coefficients are not known yet.
    """
    design = stage.design
    others = [memory for memory in stage.memories if memory not in memories_in([finding])]
    state, terms = finding.candidate.state, finding.candidate.terms
    written = tuple(column.inertia.wave for column in finding.columns if column.inertia)
    poorer = design.dropping(finding.columns)
    without, with_it = (
        derivative_fit_errors(d, all_with_memories(train, m), all_with_memories(test, m))[state]
        for d, m in ((poorer, others), (design, stage.memories))
    )
    other_names = [r.name for r in finding.rivals if r.name != finding.candidate.name]
    unknown = np.full(len(terms), np.nan)
    return Effect(
        name=finding.candidate.name,
        state=design.states[state],
        term=total(written or terms, design.symbols),
        coefficients=unknown,
        confidence_intervals=np.column_stack([unknown, unknown]),
        explained=float(1.0 - (with_it / max(without, TINY)) ** 2),
        p_value=finding.p_value,
        alternatives=(*other_names, *finding.together),
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
    if finding.candidate.acts_at is not None and len(finding.candidate.acts_at[0]) > 1:
        return _at_several(design, *finding.candidate.acts_at)
    place = entered(design, state, terms[0]) if len(terms) == 1 and finding.columns else None
    if place is None or finding.candidate.name == SATURATING:  # a rate is no force that enters
        return ""
    entry, force = place
    name = design.names[entry.beside]
    if not entry.is_known and _is_polynomial(entry.factor):  # just a product of variables
        return ""
    if entry.beside < len(design.states):
        return f"through the same factor as the damping of {name}"
    if mul(entry.factor, force) != terms[0] or not entry.is_known:
        return f"through the same factor as {name}"
    number = f"{AS_INPUT} {name} were larger by this number"
    if force == OFFSET:
        return number
    return f"{number} times {format_expression(force.to_sympy(design.symbols))}"


def _is_polynomial(factor: Sum) -> bool:
    atoms = [(atom, n) for _, term in factor.parts for atom, n in term.factors]
    return all(isinstance(atom, Variable) and n > 0 for atom, n in atoms)


def _at_several(design: Design, places: Sequence[int], force: Sequence[Sum]) -> str:
    """Say where an effect acts that is the same force at several places."""
    names = [
        f"the damping of {design.names[i]}" if i < len(design.states) else design.names[i]
        for i in places
    ]
    acting = [format_expression(compact(part.to_sympy(design.symbols))) for part in force]
    return f"where {' and '.join(names)} act, as this number times {' and '.join(acting)}"


def total(
    terms: Sequence[Sum], symbols: Sequence[Any], coef: Sequence[float] | np.ndarray = ()
) -> Any:
    """Return the sum of terms in sympy, each times its coefficient where these are known.

    Parameters
    ----------
    terms : sequence of Sum
        The terms.
    symbols : sequence of sympy.Symbol
        Of states and inputs.
    coef : sequence of float
        Coefficients; each is one if none is given.

    Returns
    -------
    sympy.Expr
    """
    factors = coef if len(coef) else [1] * len(terms)
    pairs = zip(factors, terms, strict=True)
    return sum(factor * as_written(term, symbols) for factor, term in pairs)


def _alternative(rival: Rival, design: Design) -> Alternative:
    candidate, state = rival.candidate, design.states[rival.candidate.state]
    term = total(candidate.terms, design.symbols)
    return Alternative(candidate.name, state, term, rival.p_value, candidate.terms, force=term)
