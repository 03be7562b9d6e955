"""Errors on held-out data that are larger with the effects than without them."""

from __future__ import annotations

import numpy as np

from ..effects.names import FORCING
from ..facts.outcome import Outcome
from ..facts.start_noise import run_std_from_start_noise
from ..fitting.runs import LOST_NRMSE
from .number_text import percent
from .printed_names import PARAMETRIC

# An error grew if it exceeds both. The first is more than refitted coefficients can cause.
GREW_TIMES = 1.1  # times the error of the declared model
GREW_BY = 0.1  # added to it, percent of the standard deviation
# A derivative is lost again if its error exceeds both. A final fit to free runs changes it by less.
LOST_AGAIN = 2.0  # times the error after an earlier effect
LOST_BY = 1.0  # added to it, percent of the standard deviation


def has_grown_in_all(outcome: Outcome) -> bool:
    """Tell whether all errors on held-out data are larger with the effects than without them."""
    kinds = _errors_grown(outcome)
    rated = [grew for _, before, _, has_grown in kinds for grew in has_grown[before > 0.0]]
    return bool(rated) and all(rated)


def worse_than_declared(outcome: Outcome) -> list[str]:
    """Name the errors on held-out data that are larger with the effects than without them."""
    model, grew = outcome.before.model, []
    for title, before, after, has_grown in _errors_grown(outcome):
        for k in np.flatnonzero(has_grown):
            now = percent(after[k]) if np.isfinite(after[k]) else "no finite value"
            grew.append(f"{title.format(model.states[k])} from {percent(before[k])} to {now}")
    if not grew:
        return []
    said = f"On the held-out data some errors grew: {', '.join(grew)}."
    if any(effect.name in (FORCING, PARAMETRIC) for effect in outcome.effects):
        return [f"{said} The phase of a periodic forcing may differ from record to record."]
    return [f"{said} What was found may not carry over to that record."]


def _errors_grown(outcome: Outcome) -> list[tuple[str, np.ndarray, np.ndarray, np.ndarray]]:
    """Return what each kind of error is of, the errors before and after, and whether they grew."""
    algebraic, grown = bool(outcome.before.model.n_algebraic), []
    if not outcome.effects:
        return []
    kinds = {"derivative_error": "d{}/dt", "simulation_error": "the free run of {}"}
    if algebraic:  # nothing is differentiated, and nothing runs
        kinds = {"simulation_error": "{}"}
    for kind, title in kinds.items():
        before, after = (getattr(errors, kind) for errors in (outcome.before, outcome.after))
        tolerated = np.maximum(GREW_TIMES * before, before + GREW_BY)
        worse = (before < LOST_NRMSE) & ~(after <= tolerated)  # a lost run cannot get worse
        if kind == "simulation_error" and not algebraic and worse.any():
            by_start = after - before <= run_std_from_start_noise(outcome.after.model, outcome.test)
            worse &= ~(by_start & np.isfinite(after))  # a run that diverges always counts
        grown.append((title, before, after, worse))
    return grown


def worse_than_before(outcome: Outcome) -> list[str]:
    """Name the derivatives that the model explained better before its last effects."""
    stages = list(dict.fromkeys(step.errors for step in outcome.steps))  # pairs share one
    if len(stages) < 2 or outcome.before.model.n_algebraic:
        return []
    errors = np.nan_to_num([stage.derivative_error for stage in stages], nan=np.inf)
    last, said = outcome.after.derivative_error, []
    for k, place in enumerate(np.argmin(errors, axis=0)):
        least = errors[place, k]
        if last[k] > max(LOST_AGAIN * least, least + LOST_BY):
            names = " and ".join(s.name for s in outcome.steps if s.errors is stages[place])
            said.append(
                f"With {names} the held-out error of d{outcome.after.model.states[k]}/dt came down "
                f"to {percent(least)}; with all effects it is {percent(last[k])}. One of the later "
                "effects may be wrong, or the final fit favors the free run."
            )
    return said
