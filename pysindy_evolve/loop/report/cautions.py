"""What to keep in mind of a report: held inputs, what is slow, turned signs, wrong runs."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ...export import format_expression, format_number
from ...terms import ONE
from ..effects.names import FORCING
from ..given.kinematics import disagreement
from .dilution import diluted
from .exchangeable_poles import exchangeable_poles
from .extrapolation import beyond
from .held_delays import held_delays, short_delays
from .missed import RUNAWAY, missed
from .one_force import one_force
from .record_numbers import numbers_by_record
from .record_offsets import offsets_by_record
from .shared_lines import shared_lines
from .slow_states import slow_drifts
from .start_noise import moved_by_starts
from .unidentified import unidentified_sentences
from .units import percent

if TYPE_CHECKING:
    from .report import LoopReport

__all__ = ["cautions"]

WORSE = 1.1  # times the error before: more than the choice of the coefficients makes
GREW = 0.1  # percent of the standard deviation: a smaller rise does not count
TURNED = 0.05  # of a parameter, what it must be worth with its sign turned


def cautions(report: LoopReport) -> list[str]:
    """Return what is to be kept in mind, in sentences."""
    return [sentence for say in SAYINGS for sentence in say(report)]


def _doubted(report: LoopReport) -> list[str]:
    """Name the equations such as q' = v that the records contradict."""
    design, said = report.design, []
    for state in design.doubted:
        velocity = design.derivative_of(state)
        if velocity is None:
            continue
        q, v = design.states[state], design.states[velocity]
        miss = 100.0 * disagreement(report.train, state, velocity)
        said.append(
            f"The records contradict the declared {q}' = {v}: d{q}/dt differs from {v} by "
            f"{percent(miss)}, so that equation was searched as well. Check the units of {v}, and "
            "that the columns of the records are in the order of the model."
        )
    return said


def _untold(report: LoopReport) -> list[str]:
    first = report.design.columns[: len(report.after.parameters)]  # what was declared
    return unidentified_sentences(replace(report.design, columns=first), report.train)


def _known(report: LoopReport) -> list[str]:
    """Name the effects that change the coefficient of a term that was declared as known."""
    said = []
    for effect in (one for one in report.effects if len(one.expressions) == 1):
        (expression,) = effect.expressions
        known = report.design.fixed[report.design.states.index(effect.state)]
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


def _worse(report: LoopReport) -> list[str]:
    """Name the errors on held-out data that the effects made larger."""
    model = report.before.model
    if not report.effects:
        return []
    kinds = ["derivative_error", "simulation_error"]
    titles = ["d{}/dt", "the free run of {}"]
    if model.n_algebraic:  # nothing is differentiated, and nothing runs
        kinds, titles = ["simulation_error"], ["{}"]
    grown = []
    for kind, title in zip(kinds, titles, strict=True):
        before, after = (getattr(errors, kind) for errors in (report.before, report.after))
        worse = (before < RUNAWAY) & ~(after <= np.maximum(WORSE * before, before + GREW))
        if kind == "simulation_error" and not model.n_algebraic and worse.any():
            by_start = after - before <= moved_by_starts(report.after.model, report.test)
            worse &= ~(by_start & np.isfinite(after))  # diverges from any start
        for k in np.flatnonzero(worse):
            now = percent(after[k]) if np.isfinite(after[k]) else "no finite value"
            grown.append(f"{title.format(model.states[k])} from {percent(before[k])} to {now}")
    if not grown:
        return []
    said = f"On the held-out data some errors grew: {', '.join(grown)}."
    if any(effect.name == FORCING for effect in report.effects):
        return [f"{said} The phase of a periodic forcing may differ from record to record."]
    return [f"{said} What was found may not carry over to that record."]


def _held(report: LoopReport) -> list[str]:
    """Name the inputs that are held from one sample to the next, and delays that may be that."""
    names = [report.equations.inputs[column] for column in report.found_held]
    taken = [
        f"{name} is taken to be held from each sample to the next (zero-order hold). That is how "
        "it was recorded, and not an effect of the machine."
        for name in names
    ]
    exact = held_delays(report)
    late = [
        f"The input delay of {format_expression(one.term).partition('(')[0]} is "
        f"{'half a sampling time' if one in exact else f'{share:.2g} sampling times'}. An input "
        "that is held from one sample to the next (zero-order hold) acts half a sample late by "
        "itself; the machine need not be slow. If the input is held, give prepare(..., held=True)."
        for one, share in short_delays(report)
    ]
    return [*taken, *late]


def _turned(report: LoopReport) -> list[str]:
    """Name the declared parameters that effects give another sign, or leave next to nothing of.

    What was next to nothing, as a damping in which a missing force is lost, had no sign to reverse.
    """
    before, after = report.before.parameters, report.after.parameters
    turned = [
        f"{name} from {format_number(before[name])} to {format_number(value)}"
        for name, value in after.items()
        if before[name] * value < 0.0 and TURNED < abs(value / before[name]) < 1.0 / TURNED
    ]
    gone = [
        f"{name} from {format_number(before[name])} to {format_number(value)}"
        for name, value in after.items()
        if abs(value) <= TURNED * abs(before[name]) and value != before[name]
    ]
    said = []
    if turned:
        said.append(
            f"Adding the effects reverses the sign of a parameter: {', '.join(turned)}. If the "
            "machine cannot have the new sign, an effect stands for another one, or holds a part "
            "of that term."
        )
    if gone:
        said.append(
            f"With the effects, little is left of a declared term: {', '.join(gone)}. They explain "
            "what it explained, and more; the model may not need that term."
        )
    return said


def _undefined(report: LoopReport) -> list[str]:
    if report.after.undefined == 0.0:
        return []
    return [
        f"In {percent(100 * report.after.undefined)} of the held-out rows the model has no value, "
        "such as the square root of a negative number: this range was not in the training data, "
        "or noise crossed zero. The derivative is not judged on these rows."
    ]


def _lines(report: LoopReport) -> list[str]:
    """Name the frequencies at which the residuals of all of several records have a line."""
    return [
        f"In each training record the residual of d{line.state}/dt has a line at "
        f"{line.frequency:.4g} cycles per unit of t that no input has: perhaps a forcing whose "
        "phase differs between records, which no fixed term can be."
        for line in shared_lines(report)
    ]


def _sessions(report: LoopReport) -> list[str]:
    """Say which residuals have another mean in each record."""
    return [
        f"The residual of d{state}/dt has a different mean in each training record "
        f"({', '.join(map(format_number, means))}): something that stays within a record differs "
        "between them, such as a load or the zero of a sensor, which no fixed term can be."
        for state, means in offsets_by_record(report).items()
    ]


def _numbers(report: LoopReport) -> list[str]:
    """Say which declared parameters differ between the records."""
    found = numbers_by_record(report)
    if not found:
        return []
    own = "; ".join(f"{name} is {', '.join(map(format_number, n))}" for name, n in found.items())
    what = "it was" if len(found) == 1 else "they were"
    return [
        f"Fitted to each training record by itself, {own}. With a value for each record the sum of "
        "the squared errors is at least a fifth smaller: perhaps "
        f"{what} not the same in all records."
    ]


def _left(report: LoopReport) -> list[str]:
    """Say that something is left beside the effects."""
    if not report.leaves_structure:
        return []
    return [
        "What the corrected model leaves still depends on what was measured, by more than chance "
        f"explains (p = {report.chance_left:.2g}). Something else is missing, or an effect stands "
        "for another one that was not tried."
    ]


SAYINGS = (
    _doubted,
    _known,
    one_force,
    _held,
    slow_drifts,
    _untold,
    diluted,
    exchangeable_poles,
    _turned,
    _worse,
    _undefined,
    _lines,
    _sessions,
    _numbers,
    beyond,
    missed,
    _left,
)  # in this order
