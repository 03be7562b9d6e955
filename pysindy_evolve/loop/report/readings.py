"""A simulated run as clipping sensors would show it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import sympy

from ..facts.effect import Effect

__all__ = ["clipped_by_sensors"]


def clipped_by_sensors(
    run: np.ndarray, states: Sequence[str], effects: Sequence[Effect]
) -> np.ndarray:
    """Return a run (n_samples, n_states) clipped where the sensor of a state was found to clip."""
    run = np.array(run)
    for effect in (each for each in effects if each.of_sensor):
        reading = run[:, states.index(effect.state)]
        clip = np.minimum if isinstance(effect.term, sympy.Min) else np.maximum
        clip(reading, effect.coefficients[0], out=reading)
    return run
