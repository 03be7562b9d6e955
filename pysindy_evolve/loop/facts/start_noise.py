"""Effect of the noise in the first state on a free run."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...equations import Equations
from ...signals import Record
from ..fitting.runs import free_run, nrmse
from ..given.sticking import noise_of


def run_std_from_start_noise(equations: Equations, records: Sequence[Record]) -> np.ndarray:
    """Return the standard deviation of free runs due to sensor noise in their first state.

    Parameters
    ----------
    equations : Equations
        The model.
    records : sequence of Record
        Records to run over. For one that was not made from raw data the noise is not known, and
        counts as zero.

    Returns
    -------
    ndarray of shape (n_states,)
        Percent of the standard deviation of the states, as free-run errors are; infinite if a run
        diverges.
    """
    moved = []
    for record in records:
        squares = np.zeros(record.x.shape)
        for state in range(record.n_states):
            noise = noise_of(record, state)
            if noise > 0.0:
                up, down = (_run(equations, record, state, sign * noise) for sign in (1.0, -1.0))
                squares += (0.5 * (up - down)) ** 2
        moved.append(np.sqrt(squares))
    percent = nrmse(np.concatenate(moved), np.concatenate([record.x for record in records]))
    return np.nan_to_num(percent, nan=np.inf)


def _run(equations: Equations, record: Record, state: int, shift: float) -> np.ndarray:
    """Run the model freely with a shift in one first state; NaN after it diverges."""
    x = np.array(record.x)
    x[0, state] += shift
    shifted = replace(record, x=x)
    run = free_run(equations, shifted, on_divergence="nan", tolerance=1e-7)
    return np.asarray(run[:, : record.n_states])
