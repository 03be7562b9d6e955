"""Initial hidden states, estimated from the first rows of a record."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.optimize import minimize_scalar

from ...equations import Equations, stack
from ...hidden_states.memory import with_memories_applied, with_past_inputs
from ...hidden_states.memory_equations import MemoryEquations, with_memories
from ...hidden_states.path_states import hidden_along, kind_of
from ...signals import Record
from ..given.design import Design
from ..given.rows import scale_of
from ..given.sticking import noise_of

HEADS_PER_RECORD = 8  # at most one eighth of a record is used to estimate how it began
PAST_HALVES = 4.0  # factor by which another past must lower the mean square: it halves the error
FADED = 0.05  # share of an initial hidden state below which it no longer matters
MIN_ERROR_OVER_NOISE = 3.0  # least RMS error of the first rows, in standard deviations of the noise
MOST_WAIT = 0.25  # largest share of a record to leave out until hidden states have settled
_SHORTEST = 2  # rows: a record holds no less


def with_estimated_past(equations: Equations, record: Record, *, doubted: bool = False) -> Record:
    """Return a record with the inputs before it as its first rows suggest.

    The hidden part of the state in which a run begins was not measured. By default the inputs are
    taken to have stood at their first values for long. Another value, within the range of an input,
    is taken if the default leaves more error of the derivative over the first time constant than
    sensor noise does, and the other value halves this error.

    Parameters
    ----------
    equations : Equations
        The model. Without hidden states nothing changes.
    record : Record
        What was measured.
    doubted : bool
        Whether the inputs are known to have stood elsewhere; the error need not exceed noise then.

    Returns
    -------
    Record
    """
    if not isinstance(equations, MemoryEquations):
        return record
    clear = 0.0 if doubted else MIN_ERROR_OVER_NOISE
    for memory in equations.memories:
        if memory.has_state:
            record = _with_estimated_input(
                equations, record, memory.column, memory.values[0], clear
            )
    return record


def _with_estimated_input(
    equations: MemoryEquations, record: Record, column: int, time_constant: float, clear: float
) -> Record:
    raw = record.raw_u
    longest = max(_SHORTEST, len(record) // HEADS_PER_RECORD)
    n = int(np.clip(np.ceil(time_constant / record.dt), _SHORTEST, longest))
    noise = np.array([noise_of(record, state, 1) for state in range(record.n_states)])
    scale = np.maximum(clear * noise, 1e-9 * scale_of([record.x_dot]))

    def at(value: float) -> Record:
        past = raw[0].copy()
        past[column] = value
        return with_past_inputs(record, past.tolist())

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
    return at(float(found.x)) if given > max(1.0, PAST_HALVES * found.fun) else record


def first_state(equations: Equations, record: Record) -> np.ndarray:
    """Return the state in which a free run over a record begins.

    A friction or a damper may remember the motion before the record, which was not measured. This
    memory fades over a short way or time; until then it shows in the derivatives.

    Parameters
    ----------
    equations : Equations
        The model; memories of its inputs are ignored here.
    record : Record
        What was measured.

    Returns
    -------
    ndarray of shape (n_states,)
        The first measured state, then the initial hidden states that follow measured ones.
    """
    if not isinstance(equations, MemoryEquations) or not equations.paths:
        return np.asarray(record.x[0])
    rows = stack(record.x, record.u, record.t)
    paths = equations.paths
    spans = [span for path in paths for span in kind_of(path).spans(path, rows)]
    starts = hidden_along(paths, rows[:1])[0].tolist()
    for _ in range(max(kind_of(path).order for path in paths)):  # states of a path are coupled
        for k, span in enumerate(spans):
            starts[k] = _remembered(equations, record, starts, k, span)
    return np.concatenate([record.x[0], starts])


def rates_on(equations: Equations, record: Record) -> np.ndarray:
    """Return the rates of a model on a record, initial hidden states taken from its first rows.

    Parameters
    ----------
    equations : Equations
        The model of inputs as they act; terms with memory are operators on the rows.
    record : Record
        What was measured, with inputs as they act.

    Returns
    -------
    ndarray of shape (n_samples, n_states)
    """
    full = with_memories(equations, ())
    if not isinstance(full, MemoryEquations):
        return equations.evaluate(record.x, record.u, record.t)
    x = np.column_stack([record.x, hidden_on(full, record)])
    return np.asarray(full.evaluate(x, record.u, record.t)[:, : record.n_states])


def derivative_residual(equations: Equations, record: Record) -> np.ndarray:
    """Return the residual of the derivative, initial hidden states taken from the first rows.

    Parameters
    ----------
    equations : Equations
        The model, with its memories of inputs if it has any.
    record : Record
        What was measured.

    Returns
    -------
    ndarray of shape (n_samples, n_states)
        Units of x_dot.
    """
    memories = equations.memories if isinstance(equations, MemoryEquations) else ()
    acted = with_memories_applied(with_estimated_past(equations, record), memories)
    return record.x_dot - rates_on(equations, acted)


def hidden_on(equations: MemoryEquations, record: Record) -> np.ndarray:
    """Return the hidden states that follow measured ones, their starts taken from the first rows.

    Parameters
    ----------
    equations : MemoryEquations
        The model.
    record : Record
        What was measured, with inputs as they act.

    Returns
    -------
    ndarray of shape (n_samples, n_hidden)
    """
    starts = first_state(equations, record)[record.n_states :].tolist()
    return hidden_along(equations.paths, stack(record.x, record.u, record.t), starts)


def settled_rows(design: Design, record: Record) -> np.ndarray:
    """Return the rows on which the initial hidden states no longer matter.

    Parameters
    ----------
    design : Design
        Holds terms with memory as operators on the rows.
    record : Record
        What was measured.

    Returns
    -------
    ndarray of shape (n_samples, 1)
        One or zero; one on most rows, however slow a memory is.
    """
    paths = design.paths
    wait = max((kind_of(path).fades(path) for path in paths), default=0.0)
    late = record.t - record.t[0] >= min(wait, MOST_WAIT * (record.t[-1] - record.t[0]))
    return np.asarray(late, dtype=float)[:, None]


def _remembered(
    equations: MemoryEquations,
    record: Record,
    starts: Sequence[float],
    place: int,
    span: tuple[float, float],
) -> float:
    """Estimate one hidden state at the first row within a span, given the others."""
    head = record[: max(_SHORTEST, len(record) // HEADS_PER_RECORD)]
    rows = stack(head.x, head.u, head.t)

    def along(start: float, n: int) -> np.ndarray:
        all_starts = [*starts[:place], start, *starts[place + 1 :]]
        return hidden_along(equations.paths, rows[:n], all_starts)

    low, high = (along(end, len(rows))[:, place] for end in span)
    affected = np.flatnonzero(np.abs(high - low) > FADED * (span[1] - span[0]))
    n, scale = max(_SHORTEST, 1 + int(affected.max(initial=0))), scale_of([record.x_dot])

    def miss(start: float) -> float:
        rates = equations.evaluate(
            np.column_stack([head.x[:n], along(start, n)]), *_acting(head, n)
        )
        error = head.x_dot[:n] - rates[:, : record.n_states]
        return float(np.sum((error / scale) ** 2))

    options = {"xatol": 1e-5 * (span[1] - span[0])}
    return float(minimize_scalar(miss, bounds=span, method="bounded", options=options).x)


def _acting(record: Record, n: int) -> tuple[np.ndarray | None, np.ndarray]:
    return None if record.u is None else record.u[:n], record.t[:n]
