"""The low-pass of the records took out motion that the free run has, and counts as an error."""

from __future__ import annotations

import numpy as np

from ...equations import Equations
from ...hidden_states.memory_equations import MemoryEquations
from ...signals import Record
from ..facts.outcome import Outcome
from ..fitting.runs import LOST_NRMSE, free_run, nrmse
from ..given.band import Band, driven
from .number_text import percent

MAX_LEFT = 0.5  # share of an error: below it, most of the error is motion that was taken out
NOTABLE = 0.1  # percent of the standard deviation


def fast_motion(outcome: Outcome) -> list[str]:
    """Say so where most of a free run's error is motion faster than the low-pass lets through.

    The records of a slow motion have a low cutoff, and those of a faster one are brought to the
    same.
    """
    model, errors = outcome.after.model, outcome.after.simulation_error
    has_memory = isinstance(model, MemoryEquations) and bool(model.memories or model.n_algebraic)
    if has_memory or model.n_algebraic or not errors.max() < LOST_NRMSE:
        return []
    records = [record for record in outcome.test if record.cutoff is not None]
    if len(records) < len(outcome.test):
        return []
    left = _errors_in_band(model, records)
    if not (left < MAX_LEFT * errors - NOTABLE).any():
        return []
    cutoff = max(record.cutoff or 0.0 for record in records)
    values = ", ".join(
        f"{percent(value)} ({name})" for value, name in zip(left, model.states, strict=False)
    )
    return [
        f"Most of the free runs' error is motion faster than {cutoff:.3g} cycles per unit of t, "
        "which the low-pass took out of the records, not an error of the model. After the same "
        f"low-pass the free runs miss by {values}. A record that was prepared by itself, with "
        "its own cutoff, shows more of the motion."
    ]


def _errors_in_band(equations: Equations, records: list[Record]) -> np.ndarray:
    """Return the errors of free runs, percent, (n_states,), that pass the low-pass of records."""
    misses = []
    for record in records:
        run = free_run(equations, driven(record), on_divergence="nan", tolerance=1e-7)
        band = Band((record,), ((0, 0),), len(record))
        misses.append(record.x - band.shown(run[None, :, : record.n_states])[0])
    percent_missed = nrmse(np.concatenate(misses), np.concatenate([r.x for r in records]))
    return np.nan_to_num(percent_missed, nan=np.inf)
