"""What sensors that were found to clip show of a run."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import sympy

from .effect import Effect

__all__ = ["as_read"]


def as_read(run: np.ndarray, states: Sequence[str], effects: Sequence[Effect]) -> np.ndarray:
    """Return a run (n_samples, n_states) as sensors show it that were found to clip."""
    run = np.array(run)
    for effect in (one for one in effects if one.of_sensor):
        reading = run[:, states.index(effect.state)]
        end = np.minimum if isinstance(effect.term, sympy.Min) else np.maximum
        end(reading, effect.coefficients[0], out=reading)
    return run
