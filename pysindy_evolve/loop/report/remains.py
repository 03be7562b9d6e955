"""What is left once the search has ended: the best that did not pass, and what that means."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...export import format_expression, format_number
from ...hidden_states.memory import DELAY

if TYPE_CHECKING:
    from ..evidence.rejected import Rejected
    from .effect import Effect
    from .report import LoopReport

__all__ = ["remains"]

RUNAWAY = 100.0  # percent of the standard deviation
HELD = 0.1  # sampling times by which a delay may differ from half of one
TURNED = 0.05  # of a parameter, what it must be worth with its sign turned
NOTABLE = 20.0  # the same: more than a small error of a parameter leaves in most machines


def remains(report: LoopReport) -> list[str]:
    """Return what is to be said of what was not found, in sentences."""
    said = [_last_look(report)] if report.finished or report.rejected is not None else []
    said += [_held(effect) for effect in report.effects if _is_held(effect, report)]
    if report.verdict == "untraced":
        said.append(
            "A general model, polynomials of all variables and the recent past of the inputs, "
            "predicts the residual better than it does in twins: something is there that depends "
            "on what was measured. A delay, a memory or a variable that was not measured may be it."
        )
    said += _turned(report)
    if report.after.undefined > 0.0:
        said.append(
            f"In {100 * report.after.undefined:.2g} % of the held-out rows the model has no value, "
            "such as a root of what is negative there: it was not measured for training, or noise "
            "moved it across. The derivative is not judged on these rows."
        )
    missed = np.max(report.after.simulation_error)
    if report.verdict != "untraced" and NOTABLE < missed < RUNAWAY:
        said.append(
            f"The free run still misses the record by {missed:.2g} %. To each effect that was "
            "tried, what remains looks like a random force. If no such force acts on the machine, "
            "something is missing that is not among these effects, or not clear in this record."
        )
    if not missed < RUNAWAY:
        said.append(
            "The free run leaves the record by more than the record varies. Such a run amplifies "
            "the smallest difference, or something is still missing: judge by the derivative."
        )
    if not report.finished:
        said.append(_unfinished(report))
    return said


def _turned(report: LoopReport) -> list[str]:
    """Say which declared parameters have another sign with the effects than without them."""
    before, after = report.before.parameters, report.after.parameters
    turned = [
        f"{name} from {format_number(before[name])} to {format_number(value)}"
        for name, value in after.items()
        if before[name] * value < 0.0 and abs(value) > TURNED * abs(before[name])
    ]
    if not turned:
        return []
    return [
        f"With the effects a parameter turns its sign: {', '.join(turned)}. If the machine does "
        "not allow that, an effect holds a part of it, or stands for another one."
    ]


def _is_held(effect: Effect, report: LoopReport) -> bool:
    """Tell whether a delay is the half sample by which an input lags that is held in between."""
    if effect.memory is None or effect.memory.kind != DELAY:
        return False
    first = report.train[0]
    step = first.dt if first.preparation is None else first.preparation.dt
    return bool(abs(effect.coefficients[0] - 0.5 * step) < HELD * step)


def _held(effect: Effect) -> str:
    return (
        f"The {effect.name} of {format_expression(effect.term).partition('(')[0]} is half a "
        "sampling time: so late acts an input that is held from one sample to the next "
        "(zero-order hold), and no part of the machine need be slow."
    )


def _unfinished(report: LoopReport) -> str:
    if report.rules is not None and report.rules.max_effects == 0:
        return "No effect was looked for, as max_effects is 0."
    return "The search did not come to its end: it was interrupted or met max_effects."


def _last_look(report: LoopReport) -> str:
    best = report.rejected
    if best is None:
        return "No other effect betters the model on parts of the record it was not fitted on."
    said = f"The best of what did not pass is {best.name} in the equation of {_states(report)}: "
    if not np.isnan(best.p_value):
        n_twins = len(best.twin_scores)
        better = round(best.p_value * (1 + n_twins)) - 1
        said += (
            f"{better} of {n_twins} twins show an effect as good ({_chance(best, report)}), and "
        )
    said += f"it would remove {100 * best.share:.2g} % of the error that could be explained"
    if report.rules is not None and best.share < report.rules.min_share:
        said += f", less than min_share asks for ({100 * report.rules.min_share:g} %)"
    return f"{said}."


def _chance(best: Rejected, report: LoopReport) -> str:
    """Return the p-value, and what was asked for where that is less than the significance."""
    said = f"p = {best.p_value:.2g}"
    if report.rules is not None and best.level < best.p_value <= report.rules.significance:
        said += f"; as there are several looks, each asks for {best.level:.2g}"
    return said


def _states(report: LoopReport) -> str:
    group = () if report.rejected is None else report.rejected.tried.group
    return ", ".join(dict.fromkeys(report.before.model.states[one.state] for one in group))
