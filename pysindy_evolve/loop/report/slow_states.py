"""States that nobody measured, too slow to be looked for, are not passed over in silence."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.fft import dct

from ...checks import TINY
from ...export import format_number
from ..effects.names import DRIFT
from ..effects.relaxation import longest_relaxation
from .residuals import residual_of

if TYPE_CHECKING:
    from .report import LoopReport

__all__ = ["slow_drifts", "slow_rest"]

SLOWEST = 8  # half waves in a record: what makes fewer changes over more than an eighth of it
MOST = 0.5  # share of what is left of a derivative
QUICKER = "the loop looks for faster ones only. A longer record would show it."


def slow_drifts(report: LoopReport) -> list[str]:
    """Say of a drift that it may be such a state."""
    plain = (e for e in report.effects if e.name == DRIFT and len(e.term.free_symbols) == 1)
    drifting = dict.fromkeys(one.state for one in plain)
    return [
        f"The drift of {state} may also be a state that nobody measured and that follows slowly, "
        f"over more than {_longest(report)}, an eighth of the record: {QUICKER}"
        for state in drifting
    ]


def slow_rest(report: LoopReport) -> str:
    """Say of what is left that it may be such a state, if most of it is slow; else nothing."""
    model = report.after.model
    shares = np.mean([_slow_share(residual_of(model, one)) for one in report.train], axis=0)
    slow = [f"d{model.states[k]}/dt" for k in np.flatnonzero(shares > MOST)]
    if not slow:
        return ""
    return (
        f" Most of what is left of {' and '.join(slow)} changes over more than {_longest(report)}, "
        "an eighth of the record, like a wandering sensor or force, or a state that nobody "
        f"measured: {QUICKER}"
    )


def _longest(report: LoopReport) -> str:
    return format_number(max(longest_relaxation(record) for record in report.train))


def _slow_share(left: np.ndarray) -> np.ndarray:
    """Return how much of residuals (n_samples, n_states) is slower than an eighth of them."""
    power = dct(left, axis=0, norm="ortho") ** 2
    return np.asarray(power[:SLOWEST].sum(axis=0) / np.maximum(power.sum(axis=0), TINY))
