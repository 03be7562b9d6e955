"""Sentences for a model that misses the records by more than the noise explains."""

from __future__ import annotations

import numpy as np

from ..facts.outcome import Outcome
from ..facts.start_noise import run_std_from_start_noise
from ..fitting.runs import LOST_NRMSE
from .number_text import percent
from .slow_states import slow_rest
from .unexplained import unexplained

NOTABLE_NRMSE = 20.0  # percent, of a free run: more than a small error of a parameter causes
BY_START = 0.5  # share of the error: if noise in the first state causes more, the run says little

RANDOM = (
    "None of the effects that were tried explains what remains; it may be a random disturbance. If "
    "there is none, something is missing that is not among these effects, or that this record does "
    "not show clearly."
)
UNSOUGHT = "The search stopped early: an effect that was not tried yet may explain this."
SHORT = (
    "The training data is too short to search for terms: only effects with names and small terms "
    "were tried. Measure longer, or more often."
)


def misfit_sentences(outcome: Outcome, *, judges_run: bool = True) -> list[str]:
    """Say by how much the free run over the held-out data errs; if it follows, the derivative.

    Parameters
    ----------
    outcome : Outcome
        What the loop found.
    judges_run : bool
        Whether the error of the run tells anything; else the derivative is judged.

    Returns
    -------
    list of str
        Sentences; none where the verdict says already that something is missing, unless the free
        run has lost the record.
    """
    error = float(np.max(outcome.after.simulation_error))
    if error < LOST_NRMSE and outcome.verdict == "untraced":
        return []
    by_run = judges_run and not error < NOTABLE_NRMSE  # also of a run that diverges
    sentences = _of_run(outcome, error) if by_run else _of_rates(outcome)
    if sentences and outcome.rules.by_trajectory:
        sentences[-1] += f" {SHORT}"
    return sentences


def _of_rates(outcome: Outcome) -> list[str]:
    """Say what the model leaves of the derivative beyond the noise, and why; or nothing."""
    return [f"{sentence} {_why(outcome)}" for sentence in unexplained(outcome)]


def _why(outcome: Outcome) -> str:
    """Say what may cause the error that is left."""
    return f"{RANDOM}{slow_rest(outcome)}" if outcome.finished else UNSOUGHT


def _of_run(outcome: Outcome, error: float) -> list[str]:
    moved = float(np.max(run_std_from_start_noise(outcome.after.model, outcome.test)))
    if np.isfinite(error) and moved > BY_START * error:
        does = f"moves it by {percent(moved)}" if np.isfinite(moved) else "lets it diverge"
        sentence = (
            f"The free run misses the record by {percent(error)}, but it starts from noisy "
            f"readings, and their noise alone {does}: judge by the derivative."
        )
        return [sentence, *_of_rates(outcome)]
    if error < LOST_NRMSE:
        return [f"The free run still misses the record by {percent(error)}. {_why(outcome)}"]
    lost = (
        "The free run departs from the record by more than the record varies. Either the model "
        "amplifies small differences, or something is still missing: judge by the derivative."
    )
    return [lost, *_of_rates(outcome)]
