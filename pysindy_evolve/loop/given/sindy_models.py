"""A SINDy model as the declared one: its terms stay, and their coefficients are free."""

from __future__ import annotations

from collections.abc import Sequence
from copy import deepcopy

import numpy as np
import pysindy as ps
from sklearn.exceptions import NotFittedError

from ...equations import Equations
from ...reading.library_terms import check_ordinary, from_model
from ...signals import Record
from ...terms import Sum, of_term, variable
from .design import Column, Design
from .rows import variables_of

OWNER = "close_loop(declared=...)"  # named in errors
ROUNDED = 1e-3  # relative error that a fit may make in q' = v


def design_of_sindy(model: ps.SINDy, records: Sequence[Record]) -> Design:
    """Return the design of a SINDy model; one that is not fitted is fitted first.

    Parameters
    ----------
    model : pysindy.SINDy
        Its terms with a coefficient stay, and their coefficients are free.
    records : sequence of Record
        Training records.

    Returns
    -------
    Design

    Raises
    ------
    TypeError
        If the library of the model is not one of ordinary terms.
    """
    try:
        equations = from_model(model, OWNER)
    except NotFittedError:
        equations = from_model(_fitted(model, records), OWNER)
    return _design_of_equations(equations, records)


def _fitted(model: ps.SINDy, records: Sequence[Record]) -> ps.SINDy:
    """Fit a copy, so that the caller's model stays as it was."""
    check_ordinary(model.feature_library, OWNER)
    copy = deepcopy(model)  # scikit-learn's clone refuses a CustomLibrary
    first = records[0]
    states = first.states or [f"x{i}" for i in range(first.n_states)]
    inputs = first.inputs or [f"u{i}" for i in range(first.n_inputs)]
    return copy.fit(
        [r.x for r in records],
        t=[r.t for r in records],
        x_dot=[r.x_dot for r in records],
        u=None if first.u is None else [r.u for r in records],
        feature_names=[*states, *inputs],
    )


def _design_of_equations(equations: Equations, records: Sequence[Record]) -> Design:
    """Make each coefficient free; a right-hand side that is just another state stays known.

    The records decide whether it is: a fit without a threshold leaves traces of all other terms.
    """
    n_states, variables = len(equations.states), variables_of(records[0])
    fits = variables.shape[1] == len(equations.names)  # a mismatch is reported later
    fixed, columns = [], []
    for state, expression in enumerate(equations.sums):
        other = _just_a_state(expression, state, variables, n_states) if fits else None
        fixed.append(Sum(()) if other is None else variable(other))
        for _, term in expression.parts if other is None else ():
            parts = [Sum(())] * n_states
            parts[state] = of_term(term)
            name = f"{equations.states[state]}: {term.name(equations.names)}"
            columns.append(Column(name, tuple(parts)))
    return Design(equations.states, equations.inputs, tuple(fixed), tuple(columns))


def _just_a_state(side: Sum, state: int, variables: np.ndarray, n_states: int) -> int | None:
    """Return the other state that a right-hand side follows, but for rounding, or None."""
    with np.errstate(all="ignore"):
        values = side.evaluate(variables)
    for other in (k for k in range(n_states) if k != state):
        column = variables[:, other]
        if np.sum((values - column) ** 2) <= ROUNDED**2 * np.sum(column**2):
            return other
    return None
