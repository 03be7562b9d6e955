"""The report as text and as Markdown, for readers who know the machine but not the code."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby
from textwrap import fill, indent
from typing import Any

import numpy as np
import sympy

from ...export import format_equations, format_expression, format_number
from ...export.compact import as_written
from ...export.hinges import as_hinges
from ...hidden_states.memory_equations import MemoryEquations
from ...hidden_states.path_states import paths_within
from ..facts.effect import Effect, Errors, Step
from ..facts.outcome import Outcome
from .advice import paragraphs
from .effect_text import evidence, sentence
from .experiment import plan
from .number_text import ends, percent_cell, value_within
from .printed_names import as_printed
from .remains import remains
from .verdict import verdict_of


def as_text(outcome: Outcome) -> str:
    """Return the report as plain text."""
    outcome = as_printed(outcome)
    parts = [
        fill(f"Verdict: {verdict_of(outcome)}", 96),
        "Declared model, fitted\n" + indent(_model(outcome.before), "    "),
    ]
    if outcome.effects:
        parts.append("Corrected model\n" + indent(_corrected(outcome), "    "))
    parts.append(_table(outcome))
    symbols = outcome.equations.inner_symbols
    parts += [sentence(i, effect, symbols) for i, effect in enumerate(outcome.effects, 1)]
    said = (*p_of_effects(outcome), *p_of_rivals(outcome), *remains(outcome))
    parts += [_filled(line) for line in said]
    return "\n\n".join(parts)


def _filled(line: str) -> str:
    """Return a paragraph in lines that do not break before a percent sign."""
    return fill(line.replace(" %", "\u00a0%"), 96).replace("\u00a0", " ")


def _model(errors: Errors) -> str:
    """Return the equations and, below them, the free parameters."""
    title, colon, items = free_parameters(errors).partition(": ")
    whole = ", ".join(item.replace(" ", "\u00a0") for item in items.split(", "))
    parameters = fill(f"{title}{colon}{whole}", 92, subsequent_indent="  ")
    equations = [
        fill(line, 96, subsequent_indent="    ", break_long_words=False, break_on_hyphens=False)
        for line in format_equations(errors.model).splitlines()
    ]
    lines = [*equations, parameters.replace("\u00a0", " ")]  # an interval stays in its line
    return "\n".join(line for line in lines if line)


def _corrected(outcome: Outcome) -> str:
    """Return the corrected equations, and what each sensor that clips shows."""
    readings = [
        f"The sensor of {effect.state} shows {format_expression(effect.term)}"
        for effect in outcome.effects
        if effect.of_sensor
    ]
    return "\n".join([_model(outcome.after), *note_on_shared_terms(outcome), *readings])


def note_on_shared_terms(outcome: Outcome) -> list[str]:
    """Say so where the equations do not show an effect as it is printed below, but a sum.

    With a varying inertia they show none as printed; the line of that effect says so.
    """
    if any(effect.written for effect in outcome.effects):
        return []
    before, after = outcome.before.model, outcome.after.model
    if isinstance(after, MemoryEquations):  # hidden states shift the numbers of the variables
        after = after.inner
    declared = {(before.states[k], before.terms[j]) for k, j in np.argwhere(before.coef != 0.0)}
    sides = dict(zip(after.states, map(as_hinges, after.sums), strict=True))
    told = [
        (effect.state, expression)
        for effect in outcome.effects
        for expression in (() if effect.quantities else effect.expressions)
    ]
    added = {(state, product) for state, one in told for _, product in as_hinges(one).parts}
    shown = {(state, product) for state, side in sides.items() for _, product in side.parts}
    written = [as_written(one, outcome.equations.inner_symbols) for _, one in told]
    is_split = any(
        form.is_Add and paths_within([one]) for form, (_, one) in zip(written, told, strict=True)
    )
    said = []
    if outcome.after.parameters and (declared & added or added - shown or is_split):
        said.append(
            "Where an effect below has a term in common with the rest, the equations show the sum."
        )
    if any(map(_is_power_of_sum, written)):
        said.append("The equations show the power of a difference below multiplied out.")
    return said


def _is_power_of_sum(form: Any) -> bool:
    """Tell whether a term is printed as a power of a sum, which the equations multiply out."""
    powers = (factor for factor in sympy.Mul.make_args(form) if factor.is_Pow)
    return any(p.base.is_Add and p.exp.is_Integer and p.exp > 1 for p in powers)


def free_parameters(errors: Errors) -> str:
    """Return the free parameters with their values; a misspelled name would show among them.

    Nothing for a SINDy model, whose coefficients have no names.
    """
    if not all(name.isidentifier() for name in errors.parameters):
        return ""
    intervals = errors.parameter_intervals
    texts = (
        f"{name} = {value_within(value, *intervals[name])} ({ends(*intervals[name])})"
        if name in intervals
        else f"{name} = {format_number(value)}"
        for name, value in errors.parameters.items()
    )
    what = "Free parameters, with 95 % intervals" if intervals else "Free parameters"
    return f"{what}: {', '.join(texts) or 'none'}"


HEADLINE = "Errors on held-out data, % of the standard deviation (NRMSE)"


def _table(outcome: Outcome) -> str:
    """Return both errors before and after every step, one column for each state."""
    head, rows = table_cells(outcome)
    width = max(len(name) for name, _ in rows) + 4
    columns = zip(head, *(cells for _, cells in rows), strict=True)
    widths = [max(16, *(len(text) + 2 for text in column)) for column in columns]
    lines = [HEADLINE]
    for name, cells in [("", head), *rows]:
        texts = (f"{cell:>{n}}" for cell, n in zip(cells, widths, strict=True))
        lines.append(f"    {name:<{width}}" + "".join(texts))
    return "\n".join(lines)


def table_cells(outcome: Outcome) -> tuple[list[str], list[tuple[str, list[str]]]]:
    """Return the titles of the columns, and name and values of each row."""
    states = outcome.before.model.states  # without hidden ones, which have no measured error
    stages = [("declared", outcome.before)]
    for _, group in groupby(outcome.steps, key=lambda step: id(step.errors)):
        added = list(group)
        stages.append((f"+ {_labels(added, outcome)}", added[0].errors))
    # An equation such as q' = v has no error by definition.
    rated = np.flatnonzero(outcome.before.derivative_error > 0.0).tolist()
    if outcome.before.model.n_algebraic:  # nothing is differentiated, and nothing runs
        head = [f"{states[i]}, averaged" for i in rated] + list(states)
    else:
        head = [f"d{states[i]}/dt" for i in rated] + [f"{state} free run" for state in states]
    rows = []
    for name, errors in stages:
        values = [errors.derivative_error[i] for i in rated] + list(errors.simulation_error)
        rows.append((name, [percent_cell(value) for value in values]))
    return head, rows


def _labels(added: Sequence[Step], outcome: Outcome) -> str:
    """Return the names of effects; with their states, if one of the name entered another one."""
    places: dict[str, list[str]] = {}
    for step in added:
        alike = [other for other in outcome.steps if other.name == step.name]
        here = [other for other in alike if other.state == step.state]
        name = step.name if here[0] is step else f"a further {step.name}"
        places.setdefault(name, []).extend([step.state] if len(here) < len(alike) else [])
    return ", ".join(f"{name} ({', '.join(at)})" if at else name for name, at in places.items())


def p_of_effects(outcome: Outcome) -> list[str]:
    """Explain the p-value of effects, if there are any, and how small it can be."""
    if not outcome.effects:
        return []
    fewest = min(len(effect.twin_scores) for effect in outcome.effects)
    return [
        "p of an effect: how often the same search finds one as good in twins, which are simulated "
        f"records in which nothing is missing. {1.0 / (1 + fewest):.2g} is the smallest that "
        f"{fewest} twins can show."
    ]


def p_of_rivals(outcome: Outcome) -> list[str]:
    """Explain the p-value of alternatives, if any has one; another form of an effect has none."""
    has_rivals = any(
        rival.name != effect.name for effect in outcome.effects for rival in effect.rivals
    )
    said = (
        "p of an alternative: how often chance alone would count against it as strongly if it were "
        "the true cause."
    )
    return [said] if has_rivals else []


def as_markdown(outcome: Outcome) -> str:
    """Return the report as Markdown."""
    outcome = as_printed(outcome)
    parts = [
        f"**Verdict:** {verdict_of(outcome)}",
        f"Declared model, fitted:\n\n{_code(_model(outcome.before))}",
    ]
    if outcome.effects:
        parts.append(f"Corrected model:\n\n{_code(_corrected(outcome))}")
    head, rows = table_cells(outcome)
    lines = [f"| {HEADLINE} | {' | '.join(head)} |", "|---" * (len(head) + 1) + "|"]
    lines += [f"| {name} | {' | '.join(values)} |" for name, values in rows]
    parts.append("\n".join(lines))
    for effect in outcome.effects:
        facts = [*evidence(effect, outcome.equations.inner_symbols, wide=True), _twins(effect)]
        name = f"### {effect.name} in {effect.place}"
        parts.append("\n".join([name, "", *(f"- {_shielded(fact)}" for fact in facts)]))
    parts += map(_shielded, (*p_of_effects(outcome), *p_of_rivals(outcome)))
    parts.append("\n\n".join(["### What remains", *map(_shielded, remains(outcome))]))
    if experiments := paragraphs(plan(outcome)):
        advice = [f"- **{question}** {answer}" for question, answer in experiments]
        parts.append("\n".join(["### What to measure next", "", *map(_shielded, advice)]))
    return "\n\n".join(parts) + "\n"


def _twins(effect: Effect) -> str:
    """Return how the score of an effect compares with those of twins."""
    middle, high = np.quantile(effect.twin_scores, [0.5, 1.0])
    if effect.is_limit:
        return (
            f"stays there for {effect.score:.0f} samples in a row; twins without the limit stay at "
            f"their extreme for {middle:.0f} in the median, and for {high:.0f} at most"
        )
    return (
        f"score {effect.score:.3g}; the best that the same search finds in twins, in which nothing "
        f"is missing, has a median of {middle:.2g} and a largest value of {high:.2g}"
    )


def _shielded(plain: str) -> str:
    """Return text with the characters escaped that Markdown would interpret."""
    return plain.replace("|", "\\|").replace("_", "\\_").replace("^", "\\^")


def _code(text: str) -> str:
    return f"```text\n{text}\n```"
