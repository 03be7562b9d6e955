"""An error of the free run that is faster than the low-pass of the record."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...equations import Equations
from ...hidden_states.memory_equations import MemoryEquations
from ...signals import Record
from ..facts.outcome import Outcome
from ..fitting.runs import LOST_NRMSE, free_run, nrmse
from ..given.band import Band, driven
from .number_text import percent

MAX_LEFT = 0.5  # share of an error: below it, most of the error is motion that was taken out
NOTABLE = 1.0  # percent of the standard deviation: a smaller error needs no reason


def fast_motion(outcome: Outcome) -> list[str]:
    """Say so where most of the largest error of a free run is faster than the low-pass.

    What the low-pass took out of a record does not tell whether the machine moves so. A record of
    fast motion is low-passed as those of slow motion are, where they are brought to one step.
    """
    model, errors = outcome.after.model, outcome.after.simulation_error
    has_memory = isinstance(model, MemoryEquations) and bool(model.memories)
    if has_memory or model.n_algebraic or not NOTABLE < errors.max() < LOST_NRMSE:
        return []
    cutoffs = [record.cutoff for record in outcome.test if record.cutoff is not None]
    if len(cutoffs) < len(outcome.test):
        return []
    left = _errors_in_band(model, outcome.test)
    worst = int(np.argmax(errors))
    if left[worst] > MAX_LEFT * errors[worst]:
        return []
    values = ", ".join(
        f"{percent(value)} ({name})" for value, name in zip(left, model.states, strict=False)
    )
    return [
        f"Most of the free run's error in {model.states[worst]} is motion faster than the low-pass "
        f"of the held-out data lets through ({min(cutoffs):.3g} cycles per unit of t), so the "
        "record cannot show whether it is real. After the same low-pass the free runs miss the "
        f"record by {values}."
    ]


def _errors_in_band(equations: Equations, records: Sequence[Record]) -> np.ndarray:
    """Return the errors of free runs, percent, (n_states,), that pass the low-pass of records."""
    misses = []
    for record in records:
        run = free_run(equations, driven(record), on_divergence="nan", tolerance=1e-7)
        band = Band((record,), ((0, 0),), len(record))
        misses.append(record.x - band.shown(run[None, :, : record.n_states])[0])
    percent_missed = nrmse(np.concatenate(misses), np.concatenate([r.x for r in records]))
    return np.nan_to_num(percent_missed, nan=np.inf)
