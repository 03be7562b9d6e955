"""What it means that a model misses the records by more than the noise explains."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .slow_states import slow_rest
from .start_noise import moved_by_starts
from .unexplained import unexplained
from .units import percent

if TYPE_CHECKING:
    from .report import LoopReport

__all__ = ["NOTABLE", "RUNAWAY", "missed"]

NOTABLE = 20.0  # percent of the standard deviation: more than a small error of a parameter leaves
RUNAWAY = 100.0  # percent of the standard deviation: the run has lost the record
BY_START = 0.5  # of the miss of a free run that noise in its first state makes: it says little

RANDOM = (
    "What remains looks like a random force to every effect that was tried. If no such force acts, "
    "something is missing that is not among these effects, or not clear in this record."
)
UNSOUGHT = "The search stopped early: an effect that was not tried yet may explain this."
SHORT = (
    "The training data is too short to search for terms: beside effects with names only small ones "
    "were tried. Measure longer, or more often."
)


def missed(report: LoopReport) -> list[str]:
    """Say what the free run over the held-out data misses, or else the derivative.

    Parameters
    ----------
    report : LoopReport
        What the loop found.

    Returns
    -------
    list of str
        Sentences; none where something is said to be missing anyway.
    """
    miss = float(np.max(report.after.simulation_error))
    if miss < RUNAWAY and report.verdict == "untraced":
        return []
    said = _of_rates(report) if miss < NOTABLE else _of_run(report, miss)
    if said and report.rules.by_trajectory:
        said[-1] += f" {SHORT}"
    return said


def _of_rates(report: LoopReport) -> list[str]:
    return [f"{one} {_why(report)}" for one in unexplained(report)]


def _why(report: LoopReport) -> str:
    return f"{RANDOM}{slow_rest(report)}" if report.finished else UNSOUGHT


def _of_run(report: LoopReport, miss: float) -> list[str]:
    moved = float(np.max(moved_by_starts(report.after.model, report.test)))
    if np.isfinite(miss) and moved > BY_START * miss:
        does = f"moves it by {percent(moved)}" if np.isfinite(moved) else "lets it diverge"
        said = (
            f"The free run misses the record by {percent(miss)}, but it begins where noisy sensors "
            f"say, and this noise alone {does}: judge by the derivative."
        )
        return [said, *_of_rates(report)]
    if miss < RUNAWAY:
        return [f"The free run still misses the record by {percent(miss)}. {_why(report)}"]
    left = (
        "The free run leaves the record by more than the record varies. Either it amplifies the "
        "smallest difference, or something is still missing: judge by the derivative."
    )
    return [left, *_of_rates(report)]
