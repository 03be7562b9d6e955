"""A plan of experiments in sentences, with the numbers that the one at the rig needs."""

from __future__ import annotations

from collections.abc import Mapping
from textwrap import fill
from typing import TYPE_CHECKING

from ...export import format_expression
from .units import with_unit

if TYPE_CHECKING:
    from .effect import Effect
    from .experiment import Experiment, Plan

__all__ = ["ENOUGH", "as_sentences", "paragraphs"]

ENOUGH = 5.0  # standard errors: a test at 5 % among many candidates then misses one in twenty


def as_sentences(plan: Plan, units: Mapping[str, str] | None = None) -> str:
    """Return a plan as text, a paragraph for each experiment."""
    said = paragraphs(plan, units)
    if not said:
        return "Nothing to tell apart: no effect has an alternative."
    return "\n\n".join(
        fill(f"{i}. {question} {answer}", 96, subsequent_indent="   ")
        for i, (question, answer) in enumerate(said, 1)
    )


def paragraphs(plan: Plan, units: Mapping[str, str] | None = None) -> list[tuple[str, str]]:
    """Return what is to be told apart, and how, for each experiment."""
    said = [(_title(one), " ".join(_sentences(one, units))) for one in plan.experiments]
    return said + [_in_time(effect, units) for effect in plan.in_time]


def _in_time(effect: Effect, units: Mapping[str, str] | None) -> tuple[str, str]:
    """Return what tells memories of an input apart, which only differ in how they follow it."""
    rivals = " or ".join(effect.alternatives)
    lasts = with_unit(float(effect.coefficients[0]), "t", units)
    return (
        f"{effect.name} or {rivals}, in the equation of {effect.state}?",
        "They differ in how they follow a sudden change of the input. Record steps of it, sampled "
        f"in much less than the {lasts} by which it is late.",
    )


def _title(one: Experiment) -> str:
    """Return what is to be told apart."""
    effect, rival = one.effect, one.alternative
    forms = [format_expression(e.term) for e in (effect, rival)]
    where = effect.state if effect.state == rival.state else f"{effect.state} or {rival.state}"
    return f"{effect.name} {forms[0]} or {rival.name} {forms[1]}, in the equation of {where}?"


def _sentences(one: Experiment, units: Mapping[str, str] | None = None) -> list[str]:
    """Return what to do, and what to expect of it."""
    if one.now >= ENOUGH:
        return [
            f"Against noise alone this record would tell them apart, by {one.now:.1f} standard "
            "errors where five are enough. But it holds more than noise that neither of them "
            "explains: look first for what else is missing."
        ]
    said = [f"This record tells them apart by {one.now:.1f} standard errors; five are enough."]
    said.append(f"{_what_to_do(one)}{_reached(one, units)}.")
    if one.n_records == 1:
        said.append(f"One more record as long as this one then makes it {one.then:.1f}.")
    elif one.n_records <= 20:
        said.append(f"It takes about {one.n_records} more records as long as this one.")
    else:
        return [said[0], "No motion up to ten times as large or five times as fast would do."]
    said.append(_where(one, units))
    return said


def _what_to_do(one: Experiment) -> str:
    far, fast = one.motion.amplitude, one.motion.frequency
    if far == fast == 1.0:
        return "Record the same motion once more"
    parts = []
    if far != 1.0:
        parts.append(f"with {_times(far)} the amplitude")
    if fast != 1.0:
        parts.append(f"at {_times(fast)} the frequencies")
    return "Repeat the motion " + " and ".join(parts)


def _times(factor: float) -> str:
    return f"{factor:g} times" if factor > 1.0 else f"1/{1.0 / factor:.3g} of"


def _reached(one: Experiment, units: Mapping[str, str] | None) -> str:
    parts = []
    for name, (here, there, _) in one.reach.items():
        change = "as here" if abs(there / here - 1.0) < 1e-6 else f"here {here:.3g}"
        parts.append(f"|{name}| up to {with_unit(there, name, units)} ({change})")
    return ": " + ", ".join(parts) if parts else ""


def _where(one: Experiment, units: Mapping[str, str] | None) -> str:
    place = ", ".join(
        f"{name} = {with_unit(value, name, units)}" for name, (_, _, value) in one.reach.items()
    )
    at = f", near {place}" if place else ""
    return f"There the two differ by up to {one.difference:.3g} in d{one.effect.state}/dt{at}."
