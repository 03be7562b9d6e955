"""The printed report: read once by somebody who knows the machine but not the code."""

from __future__ import annotations

from itertools import groupby
from typing import TYPE_CHECKING

import numpy as np

from ..export import format_equations, format_expression

if TYPE_CHECKING:
    from .report import Effect, LoopReport

__all__ = ["as_text", "sentence"]

VERDICTS = {
    "complete": "complete: nothing is missing that this data can show.",
    "traced": "traced: the model lacked what is listed below.",
    "untraced": "untraced: something is missing that no tried effect explains.",
}


def as_text(report: LoopReport) -> str:
    """Return the report as text of at most 100 columns."""
    parts = [
        f"Verdict: {VERDICTS[report.verdict]}",
        "Declared model, fitted\n" + _indented(format_equations(report.before.model)),
    ]
    if report.effects:
        corrected = _indented(format_equations(report.after.model))
        parts.append("Corrected model\n" + corrected)
    parts.append(_table(report))
    parts += [sentence(i, effect) for i, effect in enumerate(report.effects, 1)]
    if not report.finished:
        parts.append("The search did not come to its end: it was interrupted or met max_effects.")
    return "\n\n".join(parts)


def _indented(text: str) -> str:
    return "\n".join("    " + line for line in text.splitlines())


def _table(report: LoopReport) -> str:
    """Return both errors before and after every step, one column for each state."""
    states = report.equations.states
    rows = [("declared", report.before)]
    for _, group in groupby(report.steps, key=lambda step: id(step.errors)):
        added = list(group)
        rows.append(("+ " + ", ".join(step.name for step in added), added[0].errors))
    rated = [i for i in range(len(states)) if _is_rated(report, i)]
    head = [f"d{states[i]}/dt" for i in rated] + [f"{state} free run" for state in states]
    lines = ["Errors on held-out data, % of the standard deviation (NRMSE)"]
    width = max(len(name) for name, _ in rows) + 4
    lines.append(" " * (width + 4) + "".join(f"{title:>16}" for title in head))
    for name, errors in rows:
        values = [errors.derivative_error[i] for i in rated] + list(errors.simulation_error)
        lines.append(f"    {name:<{width}}" + "".join(f"{_percent(v):>16}" for v in values))
    return "\n".join(lines)


def _is_rated(report: LoopReport, state: int) -> bool:
    """Leave out equations such as q' = v, whose error is zero by definition."""
    return bool(report.before.derivative_error[state] > 1e-6)


def _percent(value: float) -> str:
    return "diverges" if not np.isfinite(value) else f"{value:.3g}"


def sentence(number: int, effect: Effect) -> str:
    """Return what is known of one effect, in a few lines."""
    lines = [f"{number}. {effect.name} in the equation of {effect.state}"]
    terms = [effect.term] if len(effect.coefficients) == 1 else effect.term.as_ordered_terms()
    intervals = zip(terms, effect.coefficients, effect.confidence_intervals, strict=True)
    for term, value, (low, high) in intervals:
        shown = format_expression(term)
        lines.append(f"   {value:.4g} times {shown}   (95 %: {low:.4g} to {high:.4g})")
    lines.append(
        f"   removes {100 * effect.explained:.0f} % of the held-out residual variance; "
        f"p = {effect.p_value:.2g} ({len(effect.twin_scores)} twins)"
    )
    if effect.alternatives:
        lines.append("   this data cannot tell it from: " + ", ".join(effect.alternatives))
    return "\n".join(lines)
