"""The printed report: read once by somebody who knows the machine but not the code."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby
from textwrap import fill, indent, wrap
from typing import TYPE_CHECKING, Any

import numpy as np

from ...export import format_equations, format_expression, format_number
from ...export.compact import as_written
from ...export.hinges import as_hinges
from ...hidden_states.path_states import sayings
from ..effects.candidate import OFFSET
from ..effects.periodic import FORCING, RIPPLE
from .advice import paragraphs
from .missed import NOTABLE
from .remains import remains
from .unexplained import unexplained
from .units import percent_cell

if TYPE_CHECKING:
    from .effect import Alternative, Effect, Errors
    from .report import LoopReport

__all__ = ["added_up", "as_markdown", "as_text", "free_parameters", "interval", "table_cells"]
__all__ += ["named_together", "numbers_inside", "value_within"]
__all__ += ["verdict_of", "with_sign", "without_rivals"]

VERDICTS = {
    "complete": "complete: nothing is missing that this data can show.",
    "traced": "traced: the model lacked the effects below, which have been added.",
    "untraced": "untraced: the residual has structure that none of the tried effects explains.",
}

WAVES = (FORCING, RIPPLE)  # each a sine and a cosine

MUCH_LEFT = (
    "complete: none of the effects that were tried passes, but the model misses the record by more "
    "than the noise of the sensors explains; see what remains."
)


IN_PART = (
    "traced in part: the model lacked the effects below, which have been added, but it still "
    "misses the record by more than the noise of the sensors explains; see what remains."
)


def verdict_of(report: LoopReport) -> str:
    """Return the verdict in a sentence."""
    if report.verdict == "complete" and unexplained(report):
        return MUCH_LEFT
    missed = float(np.max(report.after.simulation_error)) >= NOTABLE
    if report.verdict == "traced" and missed and unexplained(report):
        return IN_PART
    return VERDICTS[report.verdict]


def as_text(report: LoopReport) -> str:
    """Return the report as plain text."""
    parts = [
        f"Verdict: {verdict_of(report)}",
        "Declared model, fitted\n" + indent(_model(report.before), "    "),
    ]
    if report.effects:
        said = "\n".join([_model(report.after), *added_up(report), *readings(report)])
        parts.append("Corrected model\n" + indent(said, "    "))
    parts.append(_table(report))
    symbols = report.equations.inner_symbols
    parts += [sentence(i, effect, symbols) for i, effect in enumerate(report.effects, 1)]
    parts += [fill(line, 96) for line in (*p_of_rivals(report), *remains(report))]
    return "\n\n".join(parts)


def _model(errors: Errors) -> str:
    """Return the equations and, below them, the free parameters."""
    said = free_parameters(errors)
    equations = [
        fill(line, 96, subsequent_indent="    ", break_long_words=False, break_on_hyphens=False)
        for line in format_equations(errors.model).splitlines()
    ]
    lines = [*equations, fill(said, 92, subsequent_indent="  ")]
    return "\n".join(line for line in lines if line)


def added_up(report: LoopReport) -> list[str]:
    """Say it where an effect does not stand in the equations as it is printed by itself."""
    before, after = report.before.model, report.after.model
    declared = {(before.states[k], before.terms[j]) for k, j in np.argwhere(before.coef != 0.0)}
    sides = dict(zip(after.states, map(as_hinges, after.sums), strict=True))
    brought = {
        (effect.state, product)
        for effect in report.effects
        for expression in (() if effect.quantities else effect.expressions)
        for _, product in as_hinges(expression).parts
    }
    shown = {(state, product) for state, side in sides.items() for _, product in side.parts}
    said = "Where an effect below holds one of the same terms, the equations show the sum."
    return [said] if report.after.parameters and (declared & brought or brought - shown) else []


def readings(report: LoopReport) -> list[str]:
    """Return what sensors show that do not show their state everywhere, a line each."""
    read = (effect for effect in report.effects if effect.of_sensor)
    return [f"The sensor of {one.state} shows {format_expression(one.term)}" for one in read]


def free_parameters(errors: Errors) -> str:
    """Return the fitted values of what was free, so that no misspelled name hides among them.

    The terms of a SINDy model are free without a name: nothing is said of them.
    """
    if not all(name.isidentifier() for name in errors.parameters):
        return ""
    sure = errors.parameter_intervals
    shown = (
        f"{name} = {value_within(value, *sure[name])} ({_ends(*sure[name])})"
        if name in sure
        else f"{name} = {format_number(value)}"
        for name, value in errors.parameters.items()
    )
    what = "Free parameters, with 95 % intervals" if sure else "Free parameters"
    return f"{what}: {', '.join(shown) or 'none'}"


HEADLINE = "Errors on held-out data, % of the standard deviation (NRMSE)"


def _table(report: LoopReport) -> str:
    """Return both errors before and after every step, one column for each state."""
    head, rows = table_cells(report)
    width = max(len(name) for name, _ in rows) + 4
    lines = [HEADLINE, " " * (width + 4) + "".join(f"{title:>16}" for title in head)]
    for name, values in rows:
        lines.append(f"    {name:<{width}}" + "".join(f"{value:>16}" for value in values))
    return "\n".join(lines)


def table_cells(report: LoopReport) -> tuple[list[str], list[tuple[str, list[str]]]]:
    """Return the titles of the columns, and name and values of each row."""
    states = report.before.model.states  # hidden ones are not measured
    stages = [("declared", report.before)]
    for _, group in groupby(report.steps, key=lambda step: id(step.errors)):
        added = list(group)
        stages.append(("+ " + ", ".join(step.name for step in added), added[0].errors))
    rated = [i for i in range(len(states)) if _is_rated(report, i)]
    if report.before.model.n_algebraic:  # nothing is differentiated, and nothing runs
        head = [f"{states[i]}, averaged" for i in rated] + list(states)
    else:
        head = [f"d{states[i]}/dt" for i in rated] + [f"{state} free run" for state in states]
    rows = []
    for name, errors in stages:
        values = [errors.derivative_error[i] for i in rated] + list(errors.simulation_error)
        rows.append((name, [percent_cell(value) for value in values]))
    return head, rows


def _is_rated(report: LoopReport, state: int) -> bool:
    """Leave out equations such as q' = v, whose error is zero by definition."""
    return bool(report.before.derivative_error[state] > 0.0)


def interval(low: float, high: float) -> str:
    """Return a 95 % interval with enough digits to tell its ends apart."""
    return f"(95 %: {_ends(low, high)})"


def _ends(low: float, high: float) -> str:
    digits = _digits(low, high)
    return f"{low:.{digits}g} to {high:.{digits}g}"


def value_within(value: float, low: float, high: float) -> str:
    """Return a number, with as many digits as its interval where fewer round it out of that."""
    shown = format_number(value)
    is_out = low <= value <= high and not low <= float(f"{value:.4g}") <= high
    return format_number(value, _digits(low, high)) if is_out else shown


def _digits(low: float, high: float) -> int:
    size, width = max(abs(low), abs(high)), high - low
    usable = np.isfinite(size) and np.isfinite(width) and width > 0.0
    needed = 2 + int(np.ceil(np.log10(size / width))) if usable else 4
    return min(max(needed, 4), 12)


def sentence(number: int, effect: Effect, symbols: Sequence[Any]) -> str:
    """Return what is known of one effect, in a few lines."""
    lines = [f"{number}. {effect.name} in {effect.place}"]
    lines += ["   " + line for line in evidence(effect, symbols)]
    return "\n".join(lines)


def evidence(effect: Effect, symbols: Sequence[Any], *, wide: bool = False) -> list[str]:
    """Return coefficients, share, p-value and rivals of one effect, a line each."""
    lines = _quantities(effect) if effect.quantities else _coefficients(effect, symbols)
    if effect.entry:
        lines.append(f"it acts {effect.entry}")
    paths = sayings(effect.expressions, [str(symbol) for symbol in symbols], _sure(effect))
    lines += _laid_out(paths, wide) or numbers_inside(effect)
    of_what = "variance of the free runs' error" if effect.by_runs else "residual variance"
    chance = f"p = {effect.p_value:.2g} ({len(effect.twin_scores)} twins)"
    if round(100 * effect.explained) > 0:
        lines.append(f"removes {100 * effect.explained:.0f} % of the held-out {of_what}; {chance}")
    else:
        lines.append(f"by itself removes nothing of the held-out {of_what}; {chance}")
    if effect.rivals:
        rivals = "; ".join(alternative(rival, effect) for rival in effect.rivals)
        said = f"this record cannot tell it from: {rivals}"
        lines += _laid_out([said], wide)
    else:
        lines.append(without_rivals(effect))
    return [*lines, *named_together(effect)]


def _quantities(effect: Effect) -> list[str]:
    parts = zip(effect.quantities, effect.coefficients, effect.confidence_intervals, strict=True)
    term, lines = format_expression(effect.term), []
    for quantity, value, ends in parts:
        sure = "" if effect.of_sensor else f"   {interval(*ends)}"
        lines.append(f"{term}: {quantity} {value:.4g}{sure}")
    return lines


def _coefficients(effect: Effect, symbols: Sequence[Any]) -> list[str]:
    lines = []
    for k, expression in enumerate(effect.expressions):
        term, value, low, high = with_sign(effect, k, symbols)
        times = "" if expression == OFFSET else f" times {_factor(term)}"
        lines.append(f"{value_within(value, low, high)}{times}   {interval(low, high)}")
        if low < 0.0 < high and not _is_phase(effect):
            lines.append("the interval contains zero: its sign is not known apart from other terms")
    return lines


def with_sign(effect: Effect, k: int, symbols: Sequence[Any]) -> tuple[Any, float, float, float]:
    """Return a term as it is written, its coefficient, and the ends of the interval.

    A sign of the term goes to the coefficient: two in a row are hard to read.
    """
    term = as_written(effect.expressions[k], symbols)
    value, (low, high) = float(effect.coefficients[k]), effect.confidence_intervals[k]
    if term.as_coeff_Mul()[0] < 0:
        return -term, -value, -high, -low
    return term, value, low, high


def _is_phase(effect: Effect) -> bool:
    """Tell whether a coefficient near zero only says where a wave begins."""
    low, high = effect.confidence_intervals.T
    return effect.name in WAVES and bool(np.any(low * high > 0.0))


def named_together(effect: Effect) -> list[str]:
    """Say what an effect is together with another one of its equation, which is the same force."""
    return [f"with the other part of it also called {name}" for name in effect.together]


def _laid_out(sayings: Sequence[str], wide: bool) -> list[str]:
    """Break sayings into lines, if they are not to be as wide as they come."""
    if wide:
        return list(sayings)
    options: dict[str, Any] = {"subsequent_indent": "  ", "break_on_hyphens": False}
    return [line for said in sayings for line in wrap(said, 92, **options)]


def numbers_inside(effect: Effect) -> list[str]:
    """Return the numbers inside the terms of an effect, with what is known of each."""
    shown = zip(effect.numbers.items(), _sure(effect), strict=True)
    return [f"{meaning} {value:.4g}{sure}" for (meaning, value), sure in shown]


def _sure(effect: Effect) -> list[str]:
    """Return what is said after each number inside an effect: its interval, if there is one."""
    ends = effect.number_intervals
    return [f" {interval(*pair)}" if np.isfinite(pair).all() else "" for pair in ends]


def without_rivals(effect: Effect) -> str:
    """Say why no alternative of an effect is named."""
    if effect.contested:
        return "all alternatives that were tried do worse on this record, by more than chance"
    return "no other effect was tried in its place"


def p_of_rivals(report: LoopReport) -> list[str]:
    """Say what the p of alternatives is; another form of an effect itself is shown without."""
    named = any(rival.name != effect.name for effect in report.effects for rival in effect.rivals)
    said = (
        "The p beside what cannot be told from an effect is how often chance speaks as much "
        "against an alternative that is the cause."
    )
    return [said] if named else []


def alternative(rival: Alternative, effect: Effect) -> str:
    """Return name, equation if it is another one, and term of an alternative."""
    if rival.name == effect.name:
        return f"the same in the form {format_expression(rival.term)}"
    where = "" if rival.state == effect.state else f" in the equation of {rival.state}"
    return f"{rival.name} {format_expression(rival.force)}{where} (p = {rival.p_value:.2g})"


def _factor(term: Any) -> str:
    """Return a term as what a coefficient multiplies."""
    shown = format_expression(term)
    return f"({shown})" if term.is_Add else shown


def as_markdown(report: LoopReport) -> str:
    """Return the report as Markdown."""
    parts = [
        f"**Verdict:** {verdict_of(report)}",
        f"Declared model, fitted:\n\n{_code(_model(report.before))}",
    ]
    if report.effects:
        said = "\n".join([_model(report.after), *added_up(report), *readings(report)])
        parts.append(f"Corrected model:\n\n{_code(said)}")
    head, rows = table_cells(report)
    lines = [f"| {HEADLINE} | {' | '.join(head)} |", "|---" * (len(head) + 1) + "|"]
    lines += [f"| {name} | {' | '.join(values)} |" for name, values in rows]
    parts.append("\n".join(lines))
    for effect in report.effects:
        facts = [*evidence(effect, report.equations.inner_symbols, wide=True), _twins(effect)]
        name = f"### {effect.name} in {effect.place}"
        parts.append("\n".join([name, "", *(f"- {_shielded(fact)}" for fact in facts)]))
    parts += map(_shielded, p_of_rivals(report))
    parts.append("\n\n".join(["### What remains", *map(_shielded, remains(report))]))
    if plan := paragraphs(report.suggest_experiment()):
        advice = [f"- **{question}** {answer}" for question, answer in plan]
        parts.append("\n".join(["### What to measure next", "", *map(_shielded, advice)]))
    return "\n\n".join(parts) + "\n"


def _twins(effect: Effect) -> str:
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


def _shielded(text: str) -> str:
    """Return text in which no sign is taken for one of Markdown."""
    return text.replace("|", "\\|").replace("_", "\\_").replace("^", "\\^")


def _code(text: str) -> str:
    return f"```text\n{text}\n```"
