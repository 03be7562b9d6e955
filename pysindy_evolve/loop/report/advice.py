"""A plan of experiments in sentences, with the numbers that the one at the rig needs."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from textwrap import fill
from typing import TYPE_CHECKING

from ...export import format_expression
from .units import with_unit

if TYPE_CHECKING:
    from .effect import Alternative, Effect
    from .experiment import Experiment, Plan

__all__ = ["ENOUGH", "as_sentences", "paragraphs"]

MOST = 20  # records that anybody would make
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
    """Return what is to be told apart, and how; alternatives with the same answer share one."""
    said = [(_title(alike), " ".join(_sentences(alike, units))) for alike in _alike(plan)]
    return said + [_in_time(effect, units) for effect in plan.in_time]


def _alike(plan: Plan) -> list[list[Experiment]]:
    """Return groups of experiments, one each; those of an effect that need no motion share one."""
    groups: dict[Hashable, list[Experiment]] = {}
    for i, one in enumerate(plan.experiments):
        kind = "known" if _is_known(one) else "hopeless" if _is_hopeless(one) else i
        groups.setdefault((id(one.effect), kind), []).append(one)
    return list(groups.values())


def _is_known(one: Experiment) -> bool:
    return one.now >= ENOUGH


def _is_hopeless(one: Experiment) -> bool:
    return one.n_records > MOST


def _in_time(effect: Effect, units: Mapping[str, str] | None) -> tuple[str, str]:
    """Return what tells memories of an input apart, which only differ in how they follow it."""
    rivals = " or ".join(effect.alternatives)
    lasts = with_unit(float(effect.coefficients[0]), "t", units)
    return (
        f"{effect.name} or {rivals}, in the equation of {effect.state}?",
        "They differ in how they follow a sudden change of the input. Record steps of it, sampled "
        f"in much less than the {lasts} by which it is late.",
    )


def _title(alike: Sequence[Experiment]) -> str:
    """Return what is to be told apart."""
    causes: list[Effect | Alternative] = [alike[0].effect, *(one.alternative for one in alike)]
    forms = " or ".join(f"{cause.name} {_form(cause)}".rstrip() for cause in causes)
    where = " or ".join(dict.fromkeys(cause.state for cause in causes))
    return f"{forms}, in the equation of {where}?"


def _form(cause: Effect | Alternative) -> str:
    return "" if cause.term == 1 else format_expression(cause.term)  # of a constant


def _sentences(alike: Sequence[Experiment], units: Mapping[str, str] | None = None) -> list[str]:
    """Return what to do, and what to expect of it."""
    one = alike[0]
    if _is_known(one):
        return [
            f"Against noise alone this record would tell them apart, by {_now(alike)} standard "
            "errors where five are enough. But either of them leaves more than that noise, or "
            "something else in each piece: a load that nobody measured, or what else is missing. "
            "Where the report names nothing else, record for longer."
        ]
    said = [f"This record tells them apart by {_now(alike)} standard errors; five are enough."]
    if _is_hopeless(one):
        most = "No motion of up to 10 times the amplitude and 5 times the frequency"
        return [*said, f"{most} would be enough."]
    said.append(f"{_what_to_do(one)}{_reached(one, units)}.")
    if one.n_records == 1:
        said.append(f"One more record as long as this one then makes it {one.then:.1f}.")
    else:
        said.append(f"It takes about {one.n_records} more records as long as this one.")
    return [*said, _where(one, units)]


def _now(alike: Sequence[Experiment]) -> str:
    """Return by how many standard errors the record tells each of them from the effect."""
    values = sorted({f"{one.now:.1f}" for one in alike}, key=float)
    return values[0] if len(values) == 1 else f"{values[0]} to {values[-1]}"


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
