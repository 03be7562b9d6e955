"""Where hidden states begin: what inputs and motions of a record were before it."""

from __future__ import annotations

import numpy as np
from scipy.optimize import minimize_scalar

from ..boucwen import yielding_from
from ..equations import Equations, stack
from ..hidden import MemoryEquations
from ..memory import preceded, raw_inputs
from ..signals import Record
from .segments import scale_of
from .sticking import noise_of

__all__ = ["begun", "first_state"]

LONGEST = 8  # no more than the eighth part of a record tells how it began
HALVED = 4.0  # times the mean square that another past must leave: it halves the error
FADED = 0.05  # of what a friction remembered at the beginning is left when it counts no more
CLEAR = 3.0  # standard deviations of the noise, that the error must be in the mean of its rows
_SHORTEST = 2  # rows: a record holds no less


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
    longest = max(_SHORTEST, len(record) // LONGEST)
    n = int(np.clip(np.ceil(time_constant / record.dt), _SHORTEST, longest))
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


def first_state(equations: Equations, record: Record) -> np.ndarray:
    """Return where a free run over a record begins.

    What a friction remembers of the motion before the record nobody measured. It fades over a
    short way, and until then the derivatives say what it was.

    Parameters
    ----------
    equations : Equations
        The model; memories of its inputs are not looked at here.
    record : Record
        What was measured.

    Returns
    -------
    ndarray of shape (n_states,)
        The first measured state, and the hysteresis of the motion there.
    """
    if not isinstance(equations, MemoryEquations) or not equations.paths:
        return np.asarray(record.x[0])
    starts = np.zeros(len(equations.paths))
    for k in range(len(starts)):
        starts[k] = _remembered(equations, record, starts, k)
    return np.concatenate([record.x[0], starts])


def _remembered(
    equations: MemoryEquations, record: Record, starts: np.ndarray, place: int
) -> float:
    """Return w of one hysteresis at the first row, given the others."""
    head = record[: max(_SHORTEST, len(record) // LONGEST)]
    rows = stack(head.x, head.u, head.t)
    path = equations.paths[place]
    apart = yielding_from(path, rows, 1.0) - yielding_from(path, rows, -1.0)
    n = max(_SHORTEST, int(np.sum(apart > 2.0 * FADED)))  # it only falls
    rows, scale = rows[:n], scale_of([record.x_dot])

    def miss(start: float) -> float:
        at = [*starts[:place], start, *starts[place + 1 :]]
        hidden = [yielding_from(p, rows, w) for p, w in zip(equations.paths, at, strict=True)]
        rates = equations.evaluate(np.column_stack([head.x[:n], *hidden]), *_acting(head, n))
        error = head.x_dot[:n] - rates[:, : record.n_states]
        return float(np.sum((error / scale) ** 2))

    return float(minimize_scalar(miss, bounds=(-1.0, 1.0), method="bounded").x)


def _acting(record: Record, n: int) -> tuple[np.ndarray | None, np.ndarray]:
    return None if record.u is None else record.u[:n], record.t[:n]
