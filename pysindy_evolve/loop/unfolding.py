"""Hysteresis of a motion as one more state of a design, for runs that begin anywhere.

A design holds w as a term, an operator on the rows of a record, see boucwen.py. A run that begins
in the middle of a record needs it as a state, with a start of its own. Nobody measured that state,
so no miss of it counts. In 1 / L and k / L its equation is linear, so these two may be columns like
any others.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..boucwen import numbers_of, path_parts, path_rate, paths_in, yielding_from
from ..equations import stack
from ..signals import Record
from ..substitution import substituted
from ..terms import Call, Sum, as_sum, variable
from .candidate import Candidate
from .design import Column, Design, in_state

__all__ = ["paths_of", "retuned", "unfolded", "with_paths"]

FARTHEST = 4.0  # times by which runs may change a number; beyond, they have lost their way
RATES = (0.05, 20.0)  # of unloading; smaller ones look alike, and so do larger ones


def paths_of(design: Design) -> tuple[Call, ...]:
    """Return the different hystereses that a design holds; none if it is algebraic."""
    if design.algebraic:
        return ()
    return paths_in(design.equations(np.ones(len(design.columns))))


def unfolded(design: Design, *, free: bool = False) -> Design:
    """Return a design with its hystereses as states.

    Parameters
    ----------
    design : Design
        With p columns and m hystereses.
    free : bool
        Whether 1 / L and k / L of each of them are columns, the last 2 m ones.

    Returns
    -------
    Design
        The same object where there is no hysteresis.
    """
    paths = paths_of(design)
    if not paths:
        return design
    n, m = len(design.states), len(paths)
    places = range(n, n + len(design.inputs) + 1)
    moved: dict[int | Call, Sum] = {place: variable(place + m) for place in places}
    moved |= {path: variable(n + k) for k, path in enumerate(paths)}
    fixed = [substituted(side, moved) for side in design.fixed]
    nothing = (Sum(()),) * m
    columns = [
        Column(c.name, (*(substituted(part, moved) for part in c.parts), *nothing))
        for c in design.columns
    ]
    for k, path in enumerate(paths, start=n):
        state, velocity = variable(k), substituted(path.args[1], moved)
        if free:
            parts = path_parts(state, velocity)
            columns += [in_state("number", part, k, n + m) for part in parts]
        fixed.append(Sum(()) if free else path_rate(path, state, velocity))
    states = (*design.states, *(f"w{k}" for k in range(m)))
    return replace(design, states=states, fixed=tuple(fixed), columns=tuple(columns), n_hidden=m)


def with_paths(design: Design, records: Sequence[Record]) -> list[Record]:
    """Return records with the hystereses of a design, along the measured motion, as last states."""
    paths = paths_of(design)
    if not paths:
        return list(records)
    return [_with_paths(paths, record) for record in records]


def _with_paths(paths: Sequence[Call], record: Record) -> Record:
    rows, x, x_dot = stack(record.x, record.u, record.t), [record.x], [record.x_dot]
    n = rows.shape[1]
    for path in paths:
        w = yielding_from(path, rows, 0.0)
        rate = path_rate(path, variable(n), path.args[1])
        x.append(w[:, None])
        x_dot.append(rate.evaluate(np.column_stack([rows, w]))[:, None])
    seen = record.seen
    if seen is not None:  # what remembers a motion that nobody saw is not known either
        seen = np.hstack([seen, np.repeat(np.all(seen, axis=1)[:, None], len(paths), axis=1)])
    return replace(record, x=np.hstack(x), x_dot=np.hstack(x_dot), states=None, seen=seen)


def retuned(candidate: Candidate, path: Call, numbers: Sequence[float]) -> Candidate:
    """Return an effect with other numbers in its hysteresis.

    Parameters
    ----------
    candidate : Candidate
        The effect.
    path : Call
        The hysteresis as it was; an effect that is another one stays as it is.
    numbers : sequence of float
        1 / L and k / L. Where they are far off, the effect stays as it is as well.

    Returns
    -------
    Candidate
    """
    if candidate.terms != (as_sum(path),) or candidate.shape is None or numbers[0] <= 0.0:
        return candidate
    old = numbers_of(path)
    new = 1.0 / numbers[0], np.clip(numbers[1] / numbers[0], *RATES)
    if max(new[0] / old[0], old[0] / new[0]) > FARTHEST:
        return candidate
    shape = replace(candidate.shape, values=(float(new[0]), float(new[1])))
    return replace(candidate, terms=shape.terms, shape=shape)
