"""Hints at unmeasured states that are too slow for the loop to look for."""

from __future__ import annotations

import numpy as np
from scipy.fft import dct

from ...checks import TINY
from ...export import format_number
from ..effects.names import DRIFT
from ..effects.relaxation import longest_relaxation
from ..facts.outcome import Outcome
from ..facts.residuals import residual_of

N_SLOW = 8  # lowest terms of a cosine transform: those slower than an eighth of the record
MAIN_SHARE = 0.5  # share of the mean square of a residual
FASTER_ONLY = "the loop looks only for faster ones. A longer record would show it."


def slow_drifts(outcome: Outcome) -> list[str]:
    """Say that a drift that was found may be a slow state that nobody measured."""
    drifts = (
        effect
        for effect in outcome.effects
        if effect.name == DRIFT and len(effect.term.free_symbols) == 1
    )
    states = dict.fromkeys(drift.state for drift in drifts)
    return [
        f"The drift of {state} may also be a state that nobody measured and that responds slowly, "
        f"in more than {_longest(outcome)} (an eighth of the record): {FASTER_ONLY}"
        for state in states
    ]


def slow_rest(outcome: Outcome) -> str:
    """Say that the residual may come from a slow state, if most of it is slow; else nothing."""
    model = outcome.after.model
    shares = np.mean([_slow_share(residual_of(model, record)) for record in outcome.train], axis=0)
    names = [f"d{model.states[k]}/dt" for k in np.flatnonzero(shares > MAIN_SHARE)]
    if not names:
        return ""
    return (
        f" Most of what is left of {' and '.join(names)} changes over more than "
        f"{_longest(outcome)} (an eighth of the record), like a wandering sensor or force, or a "
        f"state that nobody measured: {FASTER_ONLY}"
    )


def _longest(outcome: Outcome) -> str:
    """Return the longest relaxation time that the loop looks for, units of t."""
    return format_number(max(longest_relaxation(record) for record in outcome.train))


def _slow_share(residual: np.ndarray) -> np.ndarray:
    """Return the share of residuals (n_samples, n_states) slower than an eighth of the record."""
    power = dct(residual, axis=0, norm="ortho") ** 2
    return np.asarray(power[:N_SLOW].sum(axis=0) / np.maximum(power.sum(axis=0), TINY))
