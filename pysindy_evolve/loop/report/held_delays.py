"""Delays of less than a sampling time, which are how an input was recorded, or may be in part."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...hidden_states.memory import DELAY
from ...signals.zero_order_hold import HALF
from ..given.held import held_inputs

if TYPE_CHECKING:
    from .effect import Effect
    from .report import LoopReport

__all__ = ["held_delays", "is_hold_only", "short_delays"]

HELD = 0.05  # sampling times by which a delay may differ from half of one


def is_hold_only(report: LoopReport) -> bool:
    """Tell whether nothing was found but that inputs are held between their samples."""
    return bool(report.effects) and len(held_delays(report)) == len(report.effects)


def held_delays(report: LoopReport) -> list[Effect]:
    """Return the delays that are half a sample, as exactly as the record knows them."""
    step, held = report.train[0].raw_dt, held_inputs(report.train)
    found = []
    for one in (e for e in report.effects if e.name == DELAY):
        if one.memory is None or one.memory.column in held:
            continue
        (low, high), off = one.confidence_intervals[0], one.coefficients[0] - HALF * step
        if abs(off) < max(HELD * step, 0.5 * (high - low)):
            found.append(one)
    return found


def short_delays(report: LoopReport) -> list[tuple[Effect, float]]:
    """Return the delays of less than a sampling time, which a hold may share in, in such times."""
    step, held = report.train[0].raw_dt, held_inputs(report.train)
    delays = (e for e in report.effects if e.name == DELAY)
    free = (e for e in delays if e.memory is not None and e.memory.column not in held)
    shares = ((effect, effect.coefficients[0] / step) for effect in free)
    return [(effect, float(share)) for effect, share in shares if 0.0 < share < 1.0]
