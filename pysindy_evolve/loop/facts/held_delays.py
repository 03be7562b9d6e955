"""Delays of less than a sampling time: a hold of the input (zero-order hold) may explain them."""

from __future__ import annotations

from ...hidden_states.memory import DELAY
from ...signals.zero_order_hold import HALF_SAMPLE
from ..given.held import held_inputs
from .effect import Effect
from .outcome import Outcome

HELD = 0.05  # sampling times by which the delay of a hold may differ from half a sampling time


def is_hold_only(outcome: Outcome) -> bool:
    """Tell whether all effects are delays that a hold of the input explains."""
    return bool(outcome.effects) and len(held_delays(outcome)) == len(outcome.effects)


def held_delays(outcome: Outcome) -> list[Effect]:
    """Return the delays that equal half a sampling time, within their intervals."""
    step, held = outcome.train[0].raw_dt, held_inputs(outcome.train)
    found = []
    for effect in (e for e in outcome.effects if e.name == DELAY):
        if effect.memory is None or effect.memory.column in held:
            continue
        low, high = effect.confidence_intervals[0]
        difference = effect.coefficients[0] - HALF_SAMPLE * step
        if abs(difference) < max(HELD * step, 0.5 * (high - low)):
            found.append(effect)
    return found


def short_delays(outcome: Outcome) -> list[tuple[Effect, float]]:
    """Return the delays of less than a sampling time, each with its share of a sampling time.

    Inputs that are known to be held are left out.
    """
    step, held = outcome.train[0].raw_dt, held_inputs(outcome.train)
    delays = (e for e in outcome.effects if e.name == DELAY)
    free = (e for e in delays if e.memory is not None and e.memory.column not in held)
    shares = ((effect, effect.coefficients[0] / step) for effect in free)
    return [(effect, float(share)) for effect, share in shares if 0.0 < share < 1.0]
