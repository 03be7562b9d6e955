"""Structure of equations: which terms, where they switch, and the numbers that may change.

Equations that differ only in coefficients and inner constants share one structure, so that the
scalar right-hand side is compiled once while coefficients are fitted. A *switch* is the argument g
of an sgn(g): the right-hand side jumps where g changes its sign.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ..equations import Equations
from ..operators import BUILTIN
from ..terms import Atom, Call, Product, Sum, Variable, only_atom

FIRST_MARK = 2.0  # stands for the first inner constant; 1 and -1 would not count as constants
FREE = 2  # kind of a coefficient that is a parameter; 1 and -1 stand for themselves


@dataclass(frozen=True)
class Switch:
    """An sgn(g) in the right-hand side.

    Attributes
    ----------
    g : Sum
        Its argument.
    state : int or None
        Index of the state that g is, if it is a plain state.
    external : bool
        Whether g depends on inputs and time only, so that no state can hold it at zero.
    """

    g: Sum
    state: int | None
    external: bool


@dataclass(frozen=True)
class Structure:
    """Equations without their numbers; the key of compiled programs.

    Attributes
    ----------
    n_states, n_inputs : int
        Variables are numbered states, inputs, time.
    terms : tuple of Product
        Terms that some row uses; inner constants replaced by marks `FIRST_MARK`, ...
    entries : tuple of tuple of (int, int)
        For each state, (term, kind) of its coefficients; the kind is 1, -1 or FREE.
    switches : tuple of Switch
        Distinct arguments of sgn, an argument before the one it is nested in.
    """

    n_states: int
    n_inputs: int
    terms: tuple[Product, ...]
    entries: tuple[tuple[tuple[int, int], ...], ...]
    switches: tuple[Switch, ...]


def structure_of(equations: Equations) -> tuple[Structure, tuple[float, ...]]:
    """Split equations into their structure and its parameters.

    Parameters
    ----------
    equations : Equations
        The right-hand sides.

    Returns
    -------
    structure : Structure
    parameters : tuple of float
        Free coefficients row by row, then the distinct inner constants.
    """
    terms = tuple(equations.terms[i] for i in equations.used)
    values = tuple(dict.fromkeys(c for term in terms for c in term.constants))
    mark = {value: FIRST_MARK + i for i, value in enumerate(values)}
    marked = tuple(term.with_constants([mark[c] for c in term.constants]) for term in terms)
    entries, free = [], []
    for row in np.asarray(equations.coef, dtype=float)[:, equations.used].tolist():
        kinds = [(i, _kind(c)) for i, c in enumerate(row) if c != 0.0]
        entries.append(tuple(kinds))
        free += [row[i] for i, kind in kinds if kind == FREE]
    n_states, n_inputs = len(equations.states), len(equations.inputs)
    switches = find_switches(marked, n_states)
    structure = Structure(n_states, n_inputs, marked, tuple(entries), switches)
    return structure, (*free, *values)


def find_switches(terms: tuple[Product, ...], n_states: int) -> tuple[Switch, ...]:
    """Return the distinct arguments of sgn in some terms, inner ones first."""
    arguments = dict.fromkeys(g for term in terms for g in _sign_arguments(term))
    return tuple(
        Switch(g, _plain_state(g, n_states), all(i >= n_states for i in g.variables))
        for g in arguments
    )


def is_affine(terms: tuple[Product, ...]) -> bool:
    """Tell whether signs are only factors: none squared, and none inside a function."""
    for term in terms:
        for atom, exponent in term.factors:
            if isinstance(atom, Call) and atom.operator == BUILTIN["sgn"] and exponent == 1:
                continue
            if any(True for _ in _sign_arguments(atom)):
                return False
    return True


def _sign_arguments(node: Product | Atom) -> Iterator[Sum]:
    for child in node.children:
        yield from _sign_arguments(child)
    if isinstance(node, Call) and node.operator == BUILTIN["sgn"]:
        yield node.args[0]


def _plain_state(g: Sum, n_states: int) -> int | None:
    atom = only_atom(g)
    return atom.index if isinstance(atom, Variable) and atom.index < n_states else None


def _kind(coefficient: float) -> int:
    """Keep coefficients of 1 and -1, as in dq/dt = v, out of the parameters."""
    return int(coefficient) if abs(coefficient) == 1.0 else FREE
