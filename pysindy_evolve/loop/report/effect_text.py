"""The lines about one effect: its size, what it explains, its p-value and its alternatives."""

from __future__ import annotations

from collections.abc import Sequence
from textwrap import wrap
from typing import Any

import numpy as np
import sympy

from ...export import format_expression, format_number
from ...export.compact import as_written
from ...export.symbolic import without_sign
from ...hidden_states.path_states import path_sentences
from ..effects.candidate import OFFSET
from ..effects.entries import AS_INPUT
from ..effects.names import (
    COULOMB_FRICTION,
    FORCING,
    INERTIA,
    QUADRATIC_DRAG,
    RIPPLE,
    VISCOUS_DAMPING,
)
from ..facts.effect import Alternative, Effect
from .number_text import interval, value_within
from .printed_names import OF_VELOCITY, PARAMETRIC

MANY_RIVALS = 6  # alternatives from which on the name of an effect says little
WAVES = (FORCING, PARAMETRIC, INERTIA, RIPPLE)  # each a sine and a cosine


def sentence(number: int, effect: Effect, symbols: Sequence[Any]) -> str:
    """Return the numbered title of an effect with its evidence below."""
    lines = [f"{number}. {effect.name} in {effect.place}"]
    lines += ["   " + line for line in evidence(effect, symbols)]
    return "\n".join(lines)


def evidence(effect: Effect, symbols: Sequence[Any], *, wide: bool = False) -> list[str]:
    """Return coefficients, share, p-value and alternatives of one effect, a line each."""
    lines = _quantities(effect) if effect.quantities else _coefficients(effect, symbols)
    if effect.entry:
        lines.append(f"it acts {effect.entry}")
    lines += meant(effect, symbols)
    lines += _wrapped(numbers_inside(effect, symbols), wide)
    lines += pumped(effect)
    of_what = whose_share(effect)
    chance = f"p = {effect.p_value:.2g} ({len(effect.twin_scores)} twins)"
    if round(100 * effect.explained) > 0:
        lines.append(f"removes {100 * effect.explained:.0f} % of the held-out {of_what}; {chance}")
    else:
        text = f"by itself removes nothing of the held-out {of_what}"
        lines += _wrapped([f"{text}; in the training data {chance}"], wide)
    if effect.rivals:
        rivals = "; ".join(alternative(rival, effect) for rival in effect.rivals)
        text = f"this record cannot tell it from: {rivals}"
        lines += _wrapped([text], wide)
    else:
        lines.append(without_rivals(effect))
    return [*lines, *hardly_named(effect), *named_together(effect)]


def whose_share(effect: Effect) -> str:
    """Return the variance of which `explained` is a share."""
    if effect.of_sensor:
        return "variance between the free runs and the readings"
    return "variance of the free runs' error" if effect.by_runs else "residual variance"


def _quantities(effect: Effect) -> list[str]:
    """Return lines for numbers that multiply no term: delays, time constants, limits."""
    parts = zip(effect.quantities, effect.coefficients, effect.confidence_intervals, strict=True)
    term, lines = format_expression(effect.term), []
    for quantity, value, ends in parts:
        interval_text = "" if effect.of_sensor else f"   {interval(*ends)}"
        lines.append(f"{term}: {quantity} {value_within(value, *ends)}{interval_text}")
    return lines


def _coefficients(effect: Effect, symbols: Sequence[Any]) -> list[str]:
    """Return lines for the coefficients and the terms that they multiply."""
    lines = []
    for k, expression in enumerate(effect.expressions):
        term, value, low, high = with_sign(effect, k, symbols)
        constant = " as a constant" if len(effect.expressions) > 1 else ""
        times = constant if expression == OFFSET else f" times {_in_parentheses(term)}"
        lines.append(f"{value_within(value, low, high)}{times}   {interval(low, high)}")
        lines += in_equation(effect, k, symbols)
        if low < 0.0 < high and not _only_sets_phase(effect):
            lines.append("the interval contains zero: the record does not determine its sign")
        elif 0.0 in (low, high):  # cut off at zero by settling/shape_intervals.py
            lines.append(
                "hardly determined beside the numbers inside it; zero itself was ruled out"
            )
    return lines


def in_equation(effect: Effect, k: int, symbols: Sequence[Any]) -> list[str]:
    """Say what the equation shows in the place of a coefficient and the number of its term."""
    term, value, low, high = with_sign(effect, k, symbols)
    number = float(term.as_coeff_Mul()[0])
    if number == 1.0 or effect.entry.startswith(AS_INPUT):
        return []
    factors = f"{value_within(value, low, high)} times {format_number(number)}"
    return [f"{factors} is {format_number(value * number)} in the equation"]


def with_sign(effect: Effect, k: int, symbols: Sequence[Any]) -> tuple[Any, float, float, float]:
    """Return a term as it is printed, its coefficient, and the ends of the interval.

    A number before the term moves to the coefficient, of a term with tuned numbers its sign alone:
    the number may then be one of these. If the coefficient adds to a declared input, it stays.
    """
    term, factor = as_written((effect.written or effect.expressions)[k], symbols), 1.0
    if not effect.entry.startswith(AS_INPUT):
        factor, term = without_sign(term) if effect.numbers else term.as_coeff_Mul()
    low, high = sorted(float(factor) * effect.confidence_intervals[k])
    return term, float(factor) * float(effect.coefficients[k]), low, high


def _only_sets_phase(effect: Effect) -> bool:
    """Tell whether an effect is a wave of which one coefficient is clearly not zero."""
    low, high = effect.confidence_intervals.T
    return effect.name in WAVES and bool(np.any(low * high > 0.0))


def named_together(effect: Effect) -> list[str]:
    """Name the single effect that this one forms with another effect of its equation."""
    return [f"together with another effect here it is also called {n}" for n in effect.together]


def _wrapped(sentences: Sequence[str], wide: bool) -> list[str]:
    """Break sentences into lines, unless they may be of any width."""
    if wide:
        return list(sentences)
    options: dict[str, Any] = {"subsequent_indent": "  ", "break_on_hyphens": False}
    return [line for text in sentences for line in wrap(text, 92, **options)]


def numbers_inside(effect: Effect, symbols: Sequence[Any]) -> list[str]:
    """Return the tuned numbers inside the terms of an effect, each with its interval."""
    names = [str(symbol) for symbol in symbols]
    if said := path_sentences(effect.expressions, names, _intervals_of_numbers(effect)):
        return said
    texts = _intervals_of_numbers(effect)
    shown = zip(effect.numbers.items(), effect.number_intervals, texts, strict=True)
    return [f"{what} {value_within(value, *ends)}{text}" for (what, value), ends, text in shown]


def meant(effect: Effect, symbols: Sequence[Any]) -> list[str]:
    """Say what a term is if its state is a velocity after all; or that a friction drives."""
    y, name = sympy.Symbol(effect.state, real=True), OF_VELOCITY.get(effect.name, effect.name)
    resists = {VISCOUS_DAMPING: y, COULOMB_FRICTION: sympy.sign(y), QUADRATIC_DRAG: y * abs(y)}
    drives = False
    if name in resists and not effect.entry:
        term, value, *_ = with_sign(effect, 0, symbols)
        drives = term == resists[name] and value > 0.0
    if name != effect.name:
        return [f"if {effect.state} is a velocity, it is {'negative ' if drives else ''}{name}"]
    if not drives:
        return []
    return ["its sign is positive: it drives the motion instead of resisting it"]


def pumped(effect: Effect) -> list[str]:
    """Say of which term a wave of the time varies the coefficient, if of any."""
    if effect.name not in (FORCING, PARAMETRIC):
        return []
    waves = sorted(effect.term.atoms(sympy.sin, sympy.cos), key=str)
    of_time = [wave for wave in waves if {str(symbol) for symbol in wave.free_symbols} == {"t"}]
    factors = [sympy.expand(effect.term).coeff(wave) for wave in of_time[:1]]
    return [
        f"the coefficient of {format_expression(factor)} varies periodically"
        for factor in factors
        if factor.free_symbols
    ]


def _intervals_of_numbers(effect: Effect) -> list[str]:
    """Return the interval of each number inside an effect as text; empty where there is none."""
    ends = effect.number_intervals
    return [f" {interval(*pair)}" if np.isfinite(pair).all() else "" for pair in ends]


def without_rivals(effect: Effect) -> str:
    """Say why no alternative of an effect is named."""
    if effect.contested:
        return "all alternatives that were tried do worse on this record, by more than chance"
    why = "" if effect.quantities else ", as another effect here needs it"
    return f"no other effect was tried in its place{why}"


def hardly_named(effect: Effect) -> list[str]:
    """Say so where many other effects could stand in the place of one."""
    if len(effect.rivals) < MANY_RIVALS:
        return []
    return ["with so many alternatives the record shows that something is missing, but hardly what"]


def alternative(rival: Alternative, effect: Effect) -> str:
    """Return an alternative in words: its name and term, its equation if another, and its p-value.

    Another form of the effect itself was not tested, and has no p-value.
    """
    name = name_of_alternative(rival, effect, "the form")
    where = "" if rival.state == effect.state else f" in the equation of {rival.state}"
    p_text = "" if rival.name == effect.name else f" (p = {rival.p_value:.2g})"
    of = " of" if effect.memory is not None and rival.term.is_Symbol else ""
    return f"{name}{of} {format_expression(rival.force)}{where}{p_text}"


def name_of_alternative(rival: Alternative, effect: Effect, as_form: str) -> str:
    """Return the name of an alternative; `as_form` if it is the effect in another form."""
    if rival.name != effect.name:
        return rival.name
    same_variables = rival.term.free_symbols == effect.term.free_symbols
    return as_form if same_variables else f"another {rival.name}"


def _in_parentheses(term: Any) -> str:
    """Return a term as text, in parentheses if it is a sum."""
    text = format_expression(term)
    return f"({text})" if term.is_Add else text
