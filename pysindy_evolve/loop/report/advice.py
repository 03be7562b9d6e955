"""The plan of experiments in sentences, with the numbers needed at the rig."""

from __future__ import annotations

import math
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from textwrap import fill

import numpy as np

from ...export import format_expression
from ..facts.effect import Alternative, Effect
from .motions import LARGEST_FACTOR, Motion
from .number_text import with_unit

MAX_RECORDS = 20  # a motion that needs more records is not proposed
MORE_ALIKE = "Repeat the same experiment: more data averages a load out."
SETTLE_FIRST = "Look into the notes at the end of the report first."
MANY = 100.0  # standard errors; larger numbers are not printed
# Standard errors: a test at 5 % among many candidates then misses one in twenty.
ENOUGH_STANDARD_ERRORS = 5.0


@dataclass(frozen=True, eq=False)
class Experiment:
    """A motion that tells an effect from one of its alternatives.

    Attributes
    ----------
    effect : Effect
        What was found.
    alternative : Alternative
        The effect that could have caused the same record.
    motion : Motion
        Factors of amplitude and frequency on the recorded motion.
    now : float
        Standard errors by which the record tells the two apart.
    then : float
        The same after one more record as long as this one, of the proposed motion.
    reach : dict of str to tuple of three float
        For each variable that the two depend on, and each velocity: its largest magnitude in the
        record, that in the proposed motion, and its value where the two differ most.
    difference : float
        Largest difference of the two models in the proposed motion, units of x_dot.
    target : str
        What they differ in: the derivative of the state, or an algebraic target itself.
    """

    effect: Effect
    alternative: Alternative
    motion: Motion
    now: float
    then: float
    reach: Mapping[str, tuple[float, float, float]]
    difference: float
    target: str

    @property
    def n_records(self) -> int:
        """Number of further records as long as this one, of the proposed motion, that suffice.

        Squared standard errors add up over the records.
        """
        each = max(self.then**2 - self.now**2, 1e-12)
        return max(1, int(np.ceil((ENOUGH_STANDARD_ERRORS**2 - self.now**2) / each)))


@dataclass(frozen=True)
class Plan:
    """Experiments, one for each pair of an effect and its alternative; prints as sentences.

    Attributes
    ----------
    experiments : tuple of Experiment
        In the order of the effects.
    units : mapping of str to str, optional
        Units of the variables.
    in_time : tuple of Effect
        Memories of an input that have alternatives. Sudden steps of the input tell these apart, not
        another amplitude.
    settled : bool
        Whether the report ends without a caution, so that nothing is to be mended first.
    """

    experiments: tuple[Experiment, ...]
    units: Mapping[str, str] | None = None
    in_time: tuple[Effect, ...] = ()
    settled: bool = True

    def __str__(self) -> str:
        pairs = paragraphs(self, self.units)
        if not pairs:
            return "Nothing to tell apart: no effect has an alternative."
        return "\n\n".join(
            fill(f"{i}. {question} {answer}", 96, subsequent_indent="   ")
            for i, (question, answer) in enumerate(pairs, 1)
        )


def paragraphs(plan: Plan, units: Mapping[str, str] | None = None) -> list[tuple[str, str]]:
    """Return pairs of a question (which effects to tell apart) and an answer (what to measure).

    Alternatives of an effect that share an answer share a paragraph.
    """
    groups = _alike(plan)
    first = next((alike for alike in groups if _is_known(alike[0])), None)
    answers = [
        (_title(alike), " ".join(_sentences(alike, units, plan.settled, again=alike is not first)))
        for alike in groups
    ]
    return answers + [_in_time(effect, units) for effect in plan.in_time]


def _alike(plan: Plan) -> list[list[Experiment]]:
    """Return groups of experiments that share a paragraph.

    An experiment with a motion stands alone. Those of an effect without one, because the record
    suffices or no motion does, are grouped.
    """
    groups: dict[Hashable, list[Experiment]] = {}
    for i, experiment in enumerate(plan.experiments):
        kind = "known" if _is_known(experiment) else "hopeless" if _is_hopeless(experiment) else i
        groups.setdefault((id(experiment.effect), kind), []).append(experiment)
    return list(groups.values())


def _is_known(experiment: Experiment) -> bool:
    """Tell whether the record at hand already tells the two apart."""
    return experiment.now >= ENOUGH_STANDARD_ERRORS


def _is_hopeless(experiment: Experiment) -> bool:
    """Tell whether even the best motion would need too many records."""
    return experiment.n_records > MAX_RECORDS


def _in_time(effect: Effect, units: Mapping[str, str] | None) -> tuple[str, str]:
    """Return question and answer for an input memory: its rivals differ only in transients."""
    rivals = " or ".join(effect.alternatives)
    delay = with_unit(float(effect.coefficients[0]), "t", units)
    return (
        f"{effect.name} or {rivals}, in the equation of {effect.state}?",
        "They differ in how they follow a sudden change of the input. Record steps of the input, "
        f"sampled much faster than the {delay} by which it acts late.",
    )


def _title(alike: Sequence[Experiment]) -> str:
    """Return the question: the effect and its alternatives, with their terms and equations."""
    causes: list[Effect | Alternative] = [
        alike[0].effect,
        *(experiment.alternative for experiment in alike),
    ]
    forms = " or ".join(f"{cause.name} {_form(cause)}".rstrip() for cause in causes)
    where = " or ".join(dict.fromkeys(cause.state for cause in causes))
    return f"{forms}, in the equation of {where}?"


def _form(cause: Effect | Alternative) -> str:
    """Return the terms of an effect; nothing for a constant, which its name says."""
    if cause.term == 1:
        return ""
    parts = cause.term.args
    merged = any(part.is_number and part != 1 for part in parts)  # as -0.5 of q - 1.5 and 1
    if merged or len(cause.expressions) == 1 or len(parts) != len(cause.expressions):
        return format_expression(cause.term.as_coeff_Mul()[1])
    terms = [format_expression(term) for term in parts if term != 1]
    return " and ".join(terms) + (" beside a constant" if 1 in parts else "")


def _sentences(
    alike: Sequence[Experiment], units: Mapping[str, str] | None, settled: bool, again: bool
) -> list[str]:
    """Return what to measure, and what to expect of it; in short if it was said `again`."""
    first = alike[0]
    if _is_known(first) and again:
        return [f"As above, something hides the difference ({_now(alike)} standard errors)."]
    if _is_known(first):
        return [
            "If noise were all that stood in the way, this record would tell them apart "
            f"({_now(alike)} standard errors; five are enough). But something that neither "
            "describes hides the difference: an unmeasured load, another missing effect, or a true "
            "form that is neither. "
            f"{MORE_ALIKE if settled else SETTLE_FIRST}"
        ]
    said = [f"This record tells them apart by {_now(alike)} standard errors; five are enough."]
    if _is_hopeless(first):
        times = f"{LARGEST_FACTOR:g} times the amplitude, speed and acceleration of this one"
        return [*said, f"No experiment of up to {times} would be enough."]
    said.append(f"{_what_to_do(first)}{_reached(first, units)}.")
    if first.n_records == 1:
        said.append(
            f"One such record, as long as this one, raises that to {_standard_errors(first)}."
        )
    else:
        said.append(f"It takes about {first.n_records} such records, each as long as this one.")
    return [*said, _where(first, units)]


def _standard_errors(experiment: Experiment) -> str:
    """Return by how much one more record tells the two apart; beyond many, the number is moot."""
    return f"{experiment.then:.1f}" if experiment.then < MANY else f"more than {MANY:.0f}"


def _now(alike: Sequence[Experiment]) -> str:
    """Return the standard errors by which the record tells the alternatives from the effect."""
    values = sorted({f"{experiment.now:.1f}" for experiment in alike}, key=float)
    return values[0] if len(values) == 1 else f"{values[0]} to {values[-1]}"


def _what_to_do(experiment: Experiment) -> str:
    """Return the instruction: which motion to record."""
    amplitude, frequency = experiment.motion.amplitude, experiment.motion.frequency
    if amplitude == frequency == 1.0:
        return "Repeat the same experiment"
    parts = []
    if amplitude != 1.0:
        parts.append(f"with {_times(amplitude)} the amplitude")
    if frequency != 1.0:
        parts.append(f"at {_times(frequency)} the frequencies")
    return "Repeat the experiment " + " and ".join(parts)


def _times(factor: float) -> str:
    return f"{factor:g} times" if factor > 1.0 else f"{Fraction(factor).limit_denominator(9)} of"


def _reached(experiment: Experiment, units: Mapping[str, str] | None) -> str:
    """Return the largest value of each variable in the proposed motion, and in this record."""
    parts = []
    for name, (now, proposed, _) in experiment.reach.items():
        change = "as here" if math.isclose(proposed, now, rel_tol=1e-6) else f"here {now:.3g}"
        parts.append(f"|{name}| up to {with_unit(proposed, name, units)} ({change})")
    return ": " + ", ".join(parts) if parts else ""


def _where(best: Experiment, units: Mapping[str, str] | None) -> str:
    """Return where in the proposed motion the two models differ most, and by how much."""
    place = ", ".join(
        f"{name} = {with_unit(value, name, units)}" for name, (_, _, value) in best.reach.items()
    )
    at = f", near {place}" if place else ""
    return f"They then differ by up to {best.difference:.3g} in {best.target}{at}."
