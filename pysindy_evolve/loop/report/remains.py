"""The end of a report: the best candidate that did not pass, and the cautions."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..evidence.rejected import Rejected
from ..facts.outcome import Outcome
from .cautions import cautions
from .number_text import percent
from .slow_states import slow_rest

NEGLIGIBLE = 1e-3  # share of the explainable error; a candidate that removes less is not named
MIN_CHANCE_P_VALUE = 0.5  # p-value from which on the best candidate is no better than chance


def remains(outcome: Outcome) -> list[str]:
    """Return sentences: the best candidate that did not pass, remaining structure, cautions."""
    sentences = (
        [_best_rejected(outcome)] if outcome.finished or outcome.rejected is not None else []
    )
    if outcome.verdict == "untraced" and outcome.chance_left < 1.0:
        sentences.append(
            "A general model (polynomials of all variables and the recent past of the inputs) "
            "predicts the residual better here than in twins, so the residual depends on the "
            "measured variables. Possible causes: a delay, a memory, an unmeasured variable, "
            "columns that were filtered differently, or, in a closed loop, noise of a sensor that "
            f"the controller passed on to an input.{slow_rest(outcome)}"
        )
    sentences += cautions(outcome)
    if not outcome.finished:
        sentences.append(_unfinished(outcome))
    return sentences


def _unfinished(outcome: Outcome) -> str:
    """Say why the search did not come to its end."""
    if not outcome.shows_motion:
        return "No effect was looked for: the records are smoothed so much that they show none."
    if outcome.rules.max_effects == 0:
        return "No effect was looked for, as max_effects is 0."
    why = "was interrupted" if outcome.interrupted else "reached max_effects"
    return f"The search stopped early: it {why}."


def _best_rejected(outcome: Outcome) -> str:
    """Say which candidate that did not pass was the best, and why it did not pass."""
    best = outcome.rejected
    if best is None:
        return "No other effect improves the model on parts of the record it was not fitted on."
    is_tested = not np.isnan(best.p_value)
    if not is_tested and best.share < NEGLIGIBLE:
        least = percent(100 * NEGLIGIBLE)
        return f"No other effect would remove even {least} of the error that could be explained."
    further = "a further " if any(best.name == effect.name for effect in outcome.effects) else ""
    name = f"{further}{_named(best, outcome.before.model.states)}"
    n_twins = len(best.twin_scores)
    count = f"{round(best.p_value * (1 + n_twins)) - 1} of {n_twins}" if is_tested else ""
    if is_tested and best.p_value >= MIN_CHANCE_P_VALUE:
        return (
            f"No other effect stands out: the best one left, {name}, is matched in {count} twins, "
            f"in which nothing is missing ({_p_value(best, outcome)})."
        )
    said = f"The strongest candidate that did not pass is {name}: "
    if is_tested:
        said += f"{count} twins, in which nothing is missing, show an effect as good "
        said += f"({_p_value(best, outcome)})"
    if is_tested and not best.p_value <= best.level:
        return f"{said}."
    said += ", but " if is_tested else ""
    said += f"it would remove {percent(100 * best.share)} of the error that could be explained"
    if best.share < outcome.rules.min_share:
        said += f", less than min_share asks for ({100 * outcome.rules.min_share:g} %)"
    return f"{said}."


def _p_value(best: Rejected, outcome: Outcome) -> str:
    """Return the p-value; with the level of the look if only that, not significance, rejects it."""
    text = f"p = {best.p_value:.2g}"
    if best.level < best.p_value <= outcome.rules.significance:
        text += f"; several looks share the significance, and this one asks for {best.level:.2g}"
    return text


def _named(best: Rejected, states: Sequence[str]) -> str:
    """Return the effects of a candidate, a pair of them at most, with their equations."""
    names = [one.name for one in best.tried.group]
    places = [states[one.state] for one in best.tried.group]
    if len(set(places)) == 1:
        together = " together" if len(names) > 1 else ""
        return f"{' and '.join(names)}{together} in the equation of {places[0]}"
    if len(set(names)) == 1:
        return f"{names[0]} in the equations of {' and '.join(places)}"
    pairs = zip(names[1:], places[1:], strict=True)
    others = " and ".join(f"{name} in that of {place}" for name, place in pairs)
    return f"{names[0]} in the equation of {places[0]} together with {others}"
