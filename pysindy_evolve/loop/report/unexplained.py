"""The residual of a derivative that the noise of the sensors does not explain."""

from __future__ import annotations

import numpy as np

from ...hidden_states.memory_equations import as_acting
from ..evidence.noise_floor import noise_alone
from ..facts.outcome import Outcome
from ..facts.residuals import in_percent, percent_left
from .number_text import percent

# Errors in percent of the standard deviation.
LEAST_ERROR = 5.0  # of a derivative; smaller ones are not reported
RUN_FOLLOWS = 2.0  # of a free run; below it nothing that matters can be missing
NOISE_RATIO = 3.0  # least ratio to the error that sensor noise causes, which is estimated roughly
SEED = 0  # for the simulated noise, so that a report always says the same


def unexplained(outcome: Outcome) -> list[str]:
    """Name the derivative whose residual exceeds the effect of sensor noise by the largest factor.

    Parameters
    ----------
    outcome : Outcome
        What the loop found.

    Returns
    -------
    list of str
        A few sentences; none if noise explains the residuals, or the free run over the held-out
        data follows it.
    """
    model = outcome.after.model
    if np.max(outcome.after.simulation_error) < RUN_FOLLOWS:
        return []
    if model.n_algebraic or any(record.preparation is None for record in outcome.train):
        return []
    errors = percent_left(model, outcome.train)
    by_noise = in_percent(_noise(outcome), outcome.train)
    worst = int(np.argmax(np.where(errors > LEAST_ERROR, errors / np.maximum(by_noise, 1e-9), 0.0)))
    if not errors[worst] > max(LEAST_ERROR, NOISE_RATIO * by_noise[worst]):  # also false for NaN
        return []
    left, by = f"{percent(errors[worst])} of d{model.states[worst]}/dt", percent(by_noise[worst])
    return [
        f"In the training data the model leaves {left}, where the noise of the sensors leaves "
        f"{by}, if that noise is white. (This is row by row; the table averages over windows.) "
        "A cutoff so low that it removes a part of the motion also leaves more."
    ]


def _noise(outcome: Outcome) -> np.ndarray:
    """Return the residual that sensor noise alone causes, all records stacked, (n, n_states)."""
    model, rng = outcome.after.model, np.random.default_rng(SEED)
    drawn = (noise_alone(*as_acting(model, record), rng) for record in outcome.train)
    return np.concatenate([columns for columns in drawn if columns is not None])
