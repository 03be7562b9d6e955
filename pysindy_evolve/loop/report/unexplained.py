"""How much of the derivative a model leaves that the noise of the sensors does not explain."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...hidden_states.memory_equations import as_acting
from ..evidence.noise_floor import noise_alone
from .residuals import in_percent, percent_left
from .units import percent

if TYPE_CHECKING:
    from .report import LoopReport

__all__ = ["unexplained"]

LEAST = 5.0  # percent of the standard deviation, that is left of a derivative
FOLLOWED = 2.0  # percent that a free run misses at most, where nothing of weight can be missing
TIMES = 3.0  # what the noise of the sensors leaves of it; less may be an error of its estimate
SEED = 0  # of the noise that is drawn: a report always says the same


def unexplained(report: LoopReport) -> list[str]:
    """Name the derivative of which the corrected model leaves most beside the noise.

    Parameters
    ----------
    report : LoopReport
        What the loop found.

    Returns
    -------
    list of str
        Two sentences, or none; none where the free run over the held-out data stays with it.
    """
    model = report.after.model
    if np.max(report.after.simulation_error) < FOLLOWED:
        return []
    if model.n_algebraic or any(record.preparation is None for record in report.train):
        return []
    missed = percent_left(model, report.train)
    by_noise = in_percent(_noise(report), report.train)
    worst = int(np.argmax(np.where(missed > LEAST, missed / np.maximum(by_noise, 1e-9), 0.0)))
    if not missed[worst] > max(LEAST, TIMES * by_noise[worst]):  # so too where there is no share
        return []
    left_of, by = f"{percent(missed[worst])} of d{model.states[worst]}/dt", percent(by_noise[worst])
    return [
        f"In the training data the model leaves {left_of}, where the noise of the sensors leaves "
        f"{by}. A cutoff so low that it takes off a part of the motion leaves more, too."
    ]


def _noise(report: LoopReport) -> np.ndarray:
    """Return what the noise of the sensors leaves, (n_samples, n_states) of all records."""
    model, rng = report.after.model, np.random.default_rng(SEED)
    drawn = (noise_alone(*as_acting(model, record), rng) for record in report.train)
    return np.concatenate([columns for columns in drawn if columns is not None])
