"""What is left once the search has ended: the best that did not pass, and what that means."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .cautions import cautions
from .slow_states import slow_rest
from .units import percent

if TYPE_CHECKING:
    from ..evidence.rejected import Rejected
    from .report import LoopReport

__all__ = ["remains"]

TRACE = 1e-3  # share of the error below which nobody asks which effect it was
LIKELY = 0.5  # p-value from which on a candidate is what chance shows anyway


def remains(report: LoopReport) -> list[str]:
    """Return what is to be said of what was not found, and what to keep in mind, in sentences."""
    said = [_last_look(report)] if report.finished or report.rejected is not None else []
    if report.verdict == "untraced" and report.chance_left < 1.0:
        said.append(
            "A general model, polynomials of all variables and the recent past of the inputs, "
            "predicts the residual better than it does in twins: something is there that depends "
            "on what was measured. Possible causes: a delay, a memory, an unmeasured variable, "
            "columns that were filtered differently, or, in a closed loop, noise of a sensor that "
            f"the controller passed on to an input.{slow_rest(report)}"
        )
    said += cautions(report)
    if not report.finished:
        said.append(_unfinished(report))
    return said


def _unfinished(report: LoopReport) -> str:
    if not report.shows_motion:
        return "No effect was looked for: the records are smoothed so much that they show none."
    if report.rules.max_effects == 0:
        return "No effect was looked for, as max_effects is 0."
    if len(report.effects) >= report.rules.max_effects:
        return "The search stopped early: it reached max_effects."
    return "The search stopped early: it was interrupted."


def _last_look(report: LoopReport) -> str:
    best = report.rejected
    if best is None:
        return "No other effect improves the model on parts of the record it was not fitted on."
    is_tested = not np.isnan(best.p_value)
    if not is_tested and best.share < TRACE:
        least = percent(100 * TRACE)
        return f"No other effect would remove {least} of the error that could be explained."
    again = "a further " if any(best.name == effect.name for effect in report.effects) else ""
    name = f"{again}{best.name} in the equation of {_states(report)}"
    n_twins = len(best.twin_scores)
    better = f"{round(best.p_value * (1 + n_twins)) - 1} of {n_twins}" if is_tested else ""
    if is_tested and best.p_value >= LIKELY:
        return (
            f"No other effect stands out: {better} twins, in which nothing is missing, show one as "
            f"good as the best one here, {name} ({_chance(best, report)})."
        )
    said = f"The strongest candidate that did not pass is {name}: "
    if is_tested:
        said += f"{better} twins, in which nothing is missing, show an effect as good "
        said += f"({_chance(best, report)})"
    if is_tested and not best.p_value <= best.level:
        return f"{said}."
    said += ", but " if is_tested else ""
    said += f"it would remove {percent(100 * best.share)} of the error that could be explained"
    if best.share < report.rules.min_share:
        said += f", less than min_share asks for ({100 * report.rules.min_share:g} %)"
    return f"{said}."


def _chance(best: Rejected, report: LoopReport) -> str:
    """Return the p-value, and what was asked for where that is less than the significance."""
    said = f"p = {best.p_value:.2g}"
    if best.level < best.p_value <= report.rules.significance:
        said += f"; as there are several looks, each asks for {best.level:.2g}"
    return said


def _states(report: LoopReport) -> str:
    group = () if report.rejected is None else report.rejected.tried.group
    return ", ".join(dict.fromkeys(report.before.model.states[one.state] for one in group))
