"""Where hidden states begin: what the inputs of a record were before it."""

from __future__ import annotations

import numpy as np
from scipy.optimize import minimize_scalar

from ..equations import Equations
from ..hidden import MemoryEquations
from ..memory import preceded, raw_inputs
from ..signals import Record
from .segments import scale_of
from .sticking import noise_of

__all__ = ["begun"]

LONGEST = 8  # no more than the eighth part of a record tells how it began
HALVED = 4.0  # times the mean square that another past must leave: it halves the error
CLEAR = 3.0  # standard deviations of the noise, that the error must be in the mean of its rows


def begun(equations: Equations, record: Record) -> Record:
    """Return a record before which the inputs stood where its first rows say.

    A run begins in a state, of which the hidden part was not measured. By default the inputs are
    taken to have stood at their first values for long. Where that leaves more of the derivative
    over the first time constant than the noise of the sensor does, and other values, within the
    range of the input, halve it, these are taken.

    Parameters
    ----------
    equations : Equations
        The model. Without hidden states nothing changes.
    record : Record
        What was measured.

    Returns
    -------
    Record
    """
    if not isinstance(equations, MemoryEquations):
        return record
    for memory in equations.memories:
        if memory.has_state:
            record = _begun_in(equations, record, memory.column, memory.values[0])
    return record


def _begun_in(
    equations: MemoryEquations, record: Record, column: int, time_constant: float
) -> Record:
    raw = raw_inputs(record)
    n = int(np.clip(np.ceil(time_constant / record.dt), 1, max(1, len(record) // LONGEST)))
    noise = np.array([noise_of(record, state, 1) for state in range(record.n_states)])
    scale = np.maximum(CLEAR * noise, 1e-9 * scale_of([record.x_dot]))

    def at(value: float) -> Record:
        past = raw[0].copy()
        past[column] = value
        return preceded(record, past.tolist())

    def miss(value: float) -> float:
        acts = at(value)
        for memory in equations.memories:
            acts = memory.apply(acts)
        head = acts[:n]
        rates = equations.inner.evaluate(head.x, head.u, head.t)
        return float(np.max(np.mean(((head.x_dot - rates) / scale) ** 2, axis=0)))

    ends = float(raw[:, column].min()), float(raw[:, column].max())
    if ends[0] == ends[1]:
        return record
    options = {"xatol": 1e-3 * (ends[1] - ends[0])}
    found = minimize_scalar(miss, bounds=ends, method="bounded", options=options)
    given = miss(float(raw[0, column]))
    return at(float(found.x)) if given > max(1.0, HALVED * found.fun) else record
