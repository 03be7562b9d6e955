"""The verdict of a report in a sentence."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..facts.outcome import Outcome
from .grown_errors import has_grown_in_all
from .missed import NOTABLE_NRMSE
from .unexplained import unexplained


def verdict_of(outcome: Outcome) -> str:
    """Return the verdict in a sentence."""
    return next(sentence for holds, sentence in VERDICTS[outcome.verdict] if holds(outcome))


def _is_unsearched_and_misses(outcome: Outcome) -> bool:
    return outcome.rules.max_effects == 0 and _leaves_more_than_noise(outcome)


def _leaves_more_than_noise(outcome: Outcome) -> bool:
    return bool(unexplained(outcome))


def _runs_miss(outcome: Outcome) -> bool:
    runs_off = float(np.max(outcome.after.simulation_error)) >= NOTABLE_NRMSE
    return runs_off and _leaves_more_than_noise(outcome)


def _leaves_structure(outcome: Outcome) -> bool:
    return outcome.leaves_structure


def _otherwise(_: Outcome) -> bool:
    return True


# For each verdict conditions and sentences: the first condition that holds gives the sentence.
VERDICTS: dict[str, tuple[tuple[Callable[[Outcome], bool], str], ...]] = {
    "complete": (
        (
            _is_unsearched_and_misses,
            "complete: a general model predicts no more of the record, but no effect was tried, "
            "and the model misses the record by more than the noise of the sensors explains; see "
            "what remains.",
        ),
        (
            _leaves_more_than_noise,
            "complete: none of the effects that were tried passes, but the model leaves more than "
            "the noise of the sensors explains, as it does where a random disturbance acts; see "
            "what remains.",
        ),
        (_otherwise, "complete: nothing is missing that this data can show."),
    ),
    "traced": (
        (
            has_grown_in_all,
            "traced: the model lacked the effects below in the training data, but the corrected "
            "model is further from the held-out data in every error; see what remains.",
        ),
        (
            _runs_miss,
            "traced in part: the model lacked the effects below, which have been added, but it "
            "still misses the record by more than the noise of the sensors explains; see what "
            "remains.",
        ),
        (
            _leaves_structure,
            "traced in part: the model lacked the effects below, which have been added, but what "
            "it leaves still depends on what was measured; see what remains.",
        ),
        (
            _leaves_more_than_noise,
            "traced: the model lacked the effects below, which have been added; it leaves more "
            "than the noise of the sensors explains, as it does where a random disturbance acts; "
            "see what remains.",
        ),
        (_otherwise, "traced: the model lacked the effects below, which have been added."),
    ),
    "untraced": (
        (
            _otherwise,
            "untraced: the residual has structure that none of the tried effects explains.",
        ),
    ),
}
