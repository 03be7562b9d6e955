"""Cautions at the end of a report: held inputs, slow states, reversed signs, worse runs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...export import format_expression, format_number
from ...terms import ONE
from ..facts.held_delays import held_delays, short_delays
from ..facts.outcome import Outcome
from ..facts.record_differences import numbers_by_record, offsets_by_record
from ..facts.shared_lines import shared_lines
from ..facts.unidentified import unidentified
from ..given.kinematics import disagreement
from .dilution import dilution_sentences
from .exchangeable_poles import exchangeable_poles
from .extrapolation import extrapolation_sentences
from .fast_motion import fast_motion
from .grown_errors import has_grown_in_all, worse_than_before, worse_than_declared
from .missed import NOTABLE_NRMSE, SHORT, misfit_sentences
from .number_text import percent
from .one_force import one_force
from .slow_states import slow_drifts

# Share of its former size below which little is left of a parameter. That its sign is reversed is
# said if neither size is below this share of the other.
NEGLIGIBLE = 0.05


def cautions(outcome: Outcome) -> list[str]:
    """Return all cautions about an outcome, a sentence or a short paragraph each."""
    return [sentence for caution in CAUTIONS for sentence in caution(outcome)]


def _doubted(outcome: Outcome) -> list[str]:
    """Name the equations such as q' = v that the records contradict."""
    design, said = outcome.design, []
    for state in design.doubted:
        velocity = design.derivative_of(state)
        if velocity is None:
            continue
        q, v = design.states[state], design.states[velocity]
        difference = 100.0 * disagreement(outcome.train, state, velocity)
        said.append(
            f"The records contradict the declared {q}' = {v}: d{q}/dt differs from {v} by "
            f"{percent(difference)}, so that equation was searched as well. Check the units of "
            f"{v}, and that the columns of the records are in the order of the model. If {v} was "
            "measured, noise of its sensor may be all of it."
        )
    return said


def _unidentified(outcome: Outcome) -> list[str]:
    """Name the declared parameters that the records do not determine."""
    declared = outcome.design.columns[: len(outcome.after.parameters)]  # effects come after them
    said = []
    for *others, last in unidentified(replace(outcome.design, columns=declared), outcome.train):
        if others:
            said.append(
                f"The records do not tell {', '.join(others)} from {last}: their terms are "
                "linearly dependent there, so that other values fit as well."
            )
        else:
            said.append(
                f"The records say nothing about {last}: its term is zero on all of them. "
                "Excite it, or give its value as known."
            )
    return said


def _contradicted_known(outcome: Outcome) -> list[str]:
    """Name the effects that change the coefficient of a term that was declared as known."""
    said = []
    for effect in (one for one in outcome.effects if len(one.expressions) == 1):
        (expression,) = effect.expressions
        known = outcome.design.fixed[outcome.design.states.index(effect.state)]
        given = {term: c for c, term in known.parts}
        if effect.quantities or len(expression.parts) != 1 or expression.parts[0][1] not in given:
            continue
        ((factor, term),) = expression.parts
        before = given[term]
        after = before + factor * float(effect.coefficients[0])
        what = f"{format_expression(effect.term)} with the known coefficient"
        what = "the known constant" if term == ONE else what
        said.append(
            f"The declared equation of {effect.state} holds {what} {format_number(before)}; the "
            f"record asks for {format_number(after)}. Check what was given as known."
        )
    return said


def _held(outcome: Outcome) -> list[str]:
    """Name the inputs that were found to be held, and the delays that a hold could explain."""
    names = [outcome.equations.inputs[column] for column in outcome.found_held]
    taken = [
        f"{name} is taken to be held from each sample to the next (zero-order hold), as it acts "
        "half a sampling time late. That is a way to record an input, and no effect of the machine."
        for name in names
    ]
    exact = held_delays(outcome)
    late = [
        f"The input delay of {format_expression(one.term).partition('(')[0]} is "
        f"{'half a sampling time' if one in exact else f'{share:.2g} sampling times'}. An input "
        "that is held from one sample to the next (zero-order hold) acts half a sample late by "
        "itself; the machine need not be slow. If the input is held, give prepare(..., held=True)."
        for one, share in short_delays(outcome)
    ]
    return [*taken, *late]


def _turned(outcome: Outcome) -> list[str]:
    """Name the declared parameters whose sign the effects reverse.

    A parameter that was near zero before has no sign to reverse: a declared damping can be, while
    a force is missing.
    """
    before, after = outcome.before.parameters, outcome.after.parameters
    turned = [
        name
        for name, value in after.items()
        if before[name] * value < 0.0
        and NEGLIGIBLE < abs(value / before[name]) < 1.0 / NEGLIGIBLE
        and not _may_be_zero(outcome, name)
    ]
    if not turned:
        return []
    what = "a parameter" if len(turned) == 1 else "parameters"
    return [
        f"Adding the effects reverses the sign of {what}: {_changes(outcome, turned)}. If the "
        "machine cannot have the new sign, an effect stands in for another one, or has absorbed a "
        "part of that term; if it can, the declared term had made up for what was missing."
    ]


def _gone(outcome: Outcome) -> list[str]:
    """Name the declared parameters of which the effects leave little, or nothing for sure."""
    before, after = outcome.before.parameters, outcome.after.parameters
    changed = [name for name, value in after.items() if value != before[name]]
    gone = [name for name in changed if abs(after[name]) <= NEGLIGIBLE * abs(before[name])]
    open_ = [name for name in changed if _may_be_zero(outcome, name) and name not in gone]
    said = []
    if gone:
        what, it = ("a declared term", "it") if len(gone) == 1 else ("declared terms", "them")
        said.append(
            f"With the effects, little is left of {what}: {_changes(outcome, gone)}. The model may "
            f"not need {it} any more."
        )
    if open_:
        what = "a declared parameter" if len(open_) == 1 else "declared parameters"
        said.append(
            f"With the effects, zero lies in the interval of {what}: {_changes(outcome, open_)}. "
            "An effect may have taken the place of that term; try the model without it."
        )
    return said


def _may_be_zero(outcome: Outcome, name: str) -> bool:
    """Tell whether the interval of a parameter holds zero, and not its value without effects."""
    low, high = outcome.after.parameter_intervals.get(name, (1.0, 1.0))
    return bool(low < 0.0 < high and not low <= outcome.before.parameters[name] <= high)


def _changes(outcome: Outcome, names: Sequence[str]) -> str:
    before, after = outcome.before.parameters, outcome.after.parameters
    return ", ".join(
        f"{name} from {format_number(before[name])} to {format_number(after[name])}"
        for name in names
    )


def _undefined(outcome: Outcome) -> list[str]:
    """Say in how many held-out rows the model has no finite value."""
    if outcome.after.undefined == 0.0:
        return []
    return [
        f"In {percent(100 * outcome.after.undefined)} of the held-out rows the model has no value, "
        "such as the square root of a negative number: this range was not in the training data, "
        "or noise crossed zero. The derivative is not judged on these rows."
    ]


def _lines(outcome: Outcome) -> list[str]:
    """Name the spectral lines that the residuals of all training records share."""
    return [
        f"In each training record the residual of d{line.state}/dt has a line at "
        f"{line.frequency:.4g} cycles per unit of t that no input has: perhaps a forcing whose "
        "phase differs between records, which no fixed term can describe."
        for line in shared_lines(outcome)
    ]


def _offsets(outcome: Outcome) -> list[str]:
    """Say which residuals have a mean that differs between the training records."""
    return [
        f"The residual of d{state}/dt has a different mean in each training record "
        f"({', '.join(map(format_number, means))}): something is constant within a record but "
        "differs between records, such as a load or the zero of a sensor. No fixed term can "
        "describe it."
        for state, means in offsets_by_record(outcome).items()
    ]


def _numbers(outcome: Outcome) -> list[str]:
    """Say which declared parameters differ between the records."""
    found = numbers_by_record(outcome)
    if not found:
        return []
    values = "; ".join(f"{name} is {', '.join(map(format_number, n))}" for name, n in found.items())
    what = "it was" if len(found) == 1 else "they were"
    return [
        f"Fitted to each training record by itself, {values}. With a value for each record the "
        "sum of the squared errors is at least a fifth smaller: perhaps "
        f"{what} not the same in all records."
    ]


def _leaves_structure(outcome: Outcome) -> list[str]:
    """Say that the residual of the corrected model still has structure."""
    if not outcome.leaves_structure:
        return []
    return [
        "The residual of the corrected model still depends on the measured variables, by more than "
        f"chance explains (p = {outcome.chance_left:.2g}). Something else is missing, or an effect "
        "stands in for another one that was not tried, or the columns of the records did not pass "
        "the same filter. The errors above say how much it matters."
    ]


def _misfit(outcome: Outcome) -> list[str]:
    """Say what the model misses; of a run that the effects made worse only what may help."""
    run_error = float(np.max(outcome.after.simulation_error))
    if has_grown_in_all(outcome) and run_error >= NOTABLE_NRMSE:
        return [SHORT] if outcome.rules.by_trajectory else []
    return misfit_sentences(outcome, judges_run=not fast_motion(outcome))


CAUTIONS = (
    _doubted,
    _contradicted_known,
    one_force,
    _held,
    slow_drifts,
    _unidentified,
    dilution_sentences,
    exchangeable_poles,
    _turned,
    _gone,
    worse_than_declared,
    worse_than_before,
    _undefined,
    _lines,
    _offsets,
    _numbers,
    extrapolation_sentences,
    fast_motion,
    _misfit,
    _leaves_structure,
)  # in the order of the report
