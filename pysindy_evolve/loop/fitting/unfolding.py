"""Terms with memory (paths) as hidden states of a design, for runs that begin anywhere.

A design holds a path as a term, an operator on the rows of a record, see path_states.py. A run that
begins in the middle of a record needs a hidden state instead, with its own start. That state was
not measured, so its misses do not count. Its equation is linear in some weights, which may be
columns like any others.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...equations import stack
from ...hidden_states.memory_equations import with_memories
from ...hidden_states.path_states import (
    hidden_along,
    kind_of,
    n_hidden_of,
    own_states,
    path_rates,
    with_replaced_arguments,
)
from ...signals import Record
from ...substitution import substituted
from ...terms import Call, Sum, as_sum, variable
from ..effects.candidate import Candidate
from ..given.design import Column, Design, in_state
from .fit import derivative_square
from .past import first_state

MAX_CHANGE_FACTOR = 4.0  # factor by which runs may change a number; a larger change is rejected


def paths_of(design: Design) -> tuple[Call, ...]:
    """Return the paths of a design; none if it is algebraic."""
    if design.algebraic:
        return ()
    return design.paths


def with_hidden_states(design: Design, *, free: bool = False) -> Design:
    """Return a design with hidden states in place of its paths.

    Parameters
    ----------
    design : Design
        With p columns and m paths.
    free : bool
        Whether the weights of each path are columns, the last ones.

    Returns
    -------
    Design
        The same object if there are no paths.
    """
    paths = paths_of(design)
    if not paths:
        return design
    n, m = len(design.states), n_hidden_of(paths)
    after_hidden = range(n, design.time + 1)  # inputs and time, numbered after the hidden states
    places: dict[int | Call, Sum] = {place: variable(place + m) for place in after_hidden}
    hidden = [variable(k) for k in range(n, n + m)]
    placed = [
        (path, with_replaced_arguments(path, places), own_states(hidden, paths, path))
        for path in paths
    ]
    written = places | {
        path: kind_of(path).term(shifted, states) for path, shifted, states in placed
    }
    fixed = [substituted(side, written) for side in design.fixed]
    absent = (Sum(()),) * m
    columns = [
        Column(c.name, (*(substituted(part, written) for part in c.parts), *absent))
        for c in design.columns
    ]
    for _, shifted, states in placed:
        fixed += path_rates(shifted, states)
        if free:
            last, fixed[-1] = len(fixed) - 1, Sum(())
            parts = kind_of(shifted).parts(shifted, states)
            columns += [in_state("weight", part, last, n + m) for part in parts]
    return replace(
        design,
        states=(*design.states, *(f"w{k}" for k in range(m))),
        fixed=tuple(fixed),
        columns=tuple(columns),
        n_hidden=m,
        doubted=(*design.doubted, *range(n, n + m)),  # unmeasured, so never kinematic
    )


def records_with_hidden_states(
    design: Design, records: Sequence[Record], coef: np.ndarray | None = None
) -> list[Record]:
    """Return records with hidden states, computed along the measured ones, as last states.

    Parameters
    ----------
    design : Design
        With p columns.
    records : sequence of Record
        What was measured.
    coef : ndarray of shape (p,), optional
        With these, the initial hidden states are estimated from the first rows; default: at rest.

    Returns
    -------
    list of Record
    """
    paths = paths_of(design)
    if not paths:
        return list(records)
    if coef is None:
        return [_with_hidden_states(paths, record, None) for record in records]
    full = with_memories(design.equations(coef), ())
    starts = [first_state(full, record)[record.n_states :].tolist() for record in records]
    return [_with_hidden_states(paths, r, start) for r, start in zip(records, starts, strict=True)]


def _with_hidden_states(
    paths: Sequence[Call], record: Record, starts: Sequence[float] | None
) -> Record:
    rows, n = stack(record.x, record.u, record.t), n_hidden_of(paths)
    hidden = hidden_along(paths, rows, starts)
    states = [variable(rows.shape[1] + k) for k in range(n)]
    rates = [rate for path in paths for rate in path_rates(path, own_states(states, paths, path))]
    all_rows = np.column_stack([rows, hidden])
    x = np.column_stack([record.x, hidden])
    x_dot = np.column_stack([record.x_dot, *(rate.evaluate(all_rows) for rate in rates)])
    seen = record.seen
    if seen is not None:  # the memory of an unseen motion is not known either
        is_known = np.all(seen, axis=1)[:, None]
        seen = np.hstack([seen, np.repeat(is_known, n, axis=1)])
    return replace(record, x=x, x_dot=x_dot, states=None, seen=seen)


def square_left(design: Design, records: Sequence[Record], coef: np.ndarray) -> float:
    """Return the squared residual of the derivative for given coefficients.

    Initial hidden states are estimated from the first rows: a wrong start that fades slowly would
    make a right model look wrong.
    """
    return derivative_square(
        with_hidden_states(design), records_with_hidden_states(design, records, coef), coef
    )


def retuned(candidate: Candidate, path: Call, weights: np.ndarray) -> Candidate:
    """Return an effect with other numbers in its path.

    Parameters
    ----------
    candidate : Candidate
        The effect.
    path : Call
        The path as it was; an effect with another one stays as it is.
    weights : ndarray of shape (n_weights,)
        New weights, see path_states.py; if too far off, the effect stays as it is as well.

    Returns
    -------
    Candidate
    """
    if candidate.terms != (as_sum(path),) or candidate.shape is None or weights[0] <= 0.0:
        return candidate
    kind = kind_of(path)
    old, new = kind.numbers(path), kind.numbers_from(weights)
    if max(new[0] / old[0], old[0] / new[0]) > MAX_CHANGE_FACTOR:
        return candidate
    shape = replace(candidate.shape, values=new)
    return replace(candidate, terms=shape.terms, shape=shape)
