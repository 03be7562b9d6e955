"""Free runs of a model over records, and their errors."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline

from ...equations import AlgebraicEquations, Equations
from ...hidden_states.memory_equations import MemoryEquations, with_memories
from ...signals import Record
from ...simulation import simulate
from ..given.rows import scale_of
from ..given.sensor import limits_of_states, miss_of_run, shown
from .past import first_state, hidden_on, with_estimated_past

LOST_NRMSE = 100.0  # percent: a run that misses more tells less than the mean of the record
N_STRETCHES = 16  # of each record, that `stretch_misses` runs over
REFINEMENT = 4  # steps into which splines divide each sample of an input


def free_run(
    equations: Equations, record: Record, start: np.ndarray | None = None, **options: Any
) -> np.ndarray:
    """Simulate over a record, by default from its first state.

    Prepared inputs are smooth between the samples, so they are refined by splines: straight lines
    would take five percent off a sine with eight samples a period.
    """
    if isinstance(equations, AlgebraicEquations):
        return equations.evaluate(record.x, record.u, record.t)
    if isinstance(equations, MemoryEquations) and equations.memories:
        return _run_with_memory(equations, record, **options)
    if isinstance(equations, MemoryEquations) and equations.n_algebraic:
        hidden = hidden_on(equations, record)
        x = np.column_stack([record.x, hidden])
        rates = equations.evaluate(x, record.u, record.t)
        return np.column_stack([rates[:, : record.n_states], hidden])
    start = first_state(equations, record) if start is None else start
    if record.u is None:
        return simulate(equations, start, record.t, **options)
    fine = np.interp(
        np.arange(REFINEMENT * (len(record) - 1) + 1) / REFINEMENT, np.arange(len(record)), record.t
    )
    u = CubicSpline(record.t, record.u, axis=0)(fine)
    return simulate(equations, start, fine, u, **options)[::REFINEMENT]


def _run_with_memory(equations: MemoryEquations, record: Record, **options: Any) -> np.ndarray:
    """Run over a record, with hidden states that the raw inputs determine.

    The inputs before the record were not measured, and are estimated from its first rows.
    """
    record, hidden = with_estimated_past(equations, record), []
    for memory in equations.memories:
        if memory.has_state:
            hidden.append(memory.state(record))
        record = memory.apply(record)
    run, n = free_run(with_memories(equations.inner, ()), record, **options), record.n_states
    return np.column_stack([run[:, :n], *hidden, run[:, n:]])


def simulation_errors(equations: Equations, records: Sequence[Record]) -> np.ndarray:
    """Return the NRMSE of free runs over records, percent, shape (n_states,)."""
    equations, limits = with_memories(equations, ()), limits_of_states(records)
    errors, values = [], []
    for record in records:
        run = free_run(equations, record, on_divergence="nan", tolerance=1e-7)
        errors.append(miss_of_run(record.x, run[:, : record.n_states], limits, record.seen))
        values.append(shown(record.x, limits))
    return np.nan_to_num(nrmse(np.concatenate(errors), np.concatenate(values)), nan=np.inf)


def nrmse(errors: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return the RMS of each column of errors, percent of the standard deviation of the values.

    A column of values that never change counts as if its standard deviation were one.
    """
    return 100.0 * np.sqrt(np.mean(errors**2, axis=0)) / scale_of([values])


def stretch_misses(equations: Equations, records: Sequence[Record]) -> float:
    """Return the sum of squared misses of runs over stretches of records.

    Each run starts on its record. Misses are in standard deviations of the states. Infinite if a
    run diverges.
    """
    scale = scale_of([record.x for record in records])
    equations, limits = with_memories(equations, ()), limits_of_states(records)
    squares = []
    for record in records:
        for rows in np.array_split(np.arange(len(record)), N_STRETCHES):
            piece = record[int(rows[0]) : int(rows[-1]) + 1]
            run = free_run(equations, piece, on_divergence="nan", tolerance=1e-7)
            miss = miss_of_run(piece.x, run[:, : piece.n_states], limits, piece.seen)
            squares.append(np.sum((miss / scale) ** 2))
    return float(np.nan_to_num(np.sum(squares), nan=np.inf))
