"""What is left once the search has ended: the best that did not pass, and what that means."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from .report import LoopReport

__all__ = ["remains"]


def remains(report: LoopReport) -> list[str]:
    """Return what is to be said of what was not found, in sentences."""
    said = [_last_look(report)]
    if report.verdict == "untraced":
        said.append(
            "A general model, polynomials of all variables and the recent past of the inputs, "
            "predicts the residual better than it does in twins: something is there that depends "
            "on what was measured. A delay, a memory or a variable that was not measured may be it."
        )
    if not report.finished:
        said.append("The search did not come to its end: it was interrupted or met max_effects.")
    return said


def _last_look(report: LoopReport) -> str:
    best = report.rejected
    if best is None:
        if report.verdict == "complete":
            return (
                "No effect of the vocabulary betters the model on parts that it was not fitted on."
            )
        return "Nothing more was tried."
    name = f"{best.name} in the equation of {_states(report)}"
    if np.isnan(best.p_value):
        least = (
            "" if report.rules is None else f", less than min_share = {report.rules.min_share:g}"
        )
        return (
            f"The best of what did not pass is {name}: it would remove {100 * best.share:.2g} % of "
            f"the error that could be explained{least}."
        )
    better = int(np.sum(best.twin_scores >= best.score))
    return (
        f"The best of what did not pass is {name}: of {len(best.twin_scores)} twins, in which "
        f"nothing is missing, {better} show an effect as good (p = {best.p_value:.2g})."
    )


def _states(report: LoopReport) -> str:
    group = () if report.rejected is None else report.rejected.tried.group
    return ", ".join(dict.fromkeys(report.equations.states[one.state] for one in group))
