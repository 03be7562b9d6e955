"""Functions through which the declared model takes inputs that jump."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from ...signals import Record
from ...signals.acting import InputFunction
from ...signals.zero_order_hold import acting_through
from ...terms import Product, Sum, add, constant, mul
from .design import Design
from .input_errors import is_held
from .rows import rows_of


def with_functions(
    design: Design, train: Sequence[Record], others: Sequence[Record] = ()
) -> list[Record]:
    """Return records whose low-pass acts on functions of the inputs, not on the inputs.

    Parameters
    ----------
    design : Design
        The declared model.
    train, others : sequence of Record
        Records to fit on, and more records.

    Returns
    -------
    list of Record
        All of them. Changed are inputs that jump and enter the model through one function, or
        through several with the same other factors, whose sum then acts.
    """
    records, found = [*train, *others], {}
    for column in range(len(design.inputs)):
        if all(is_held(record, column) for record in records):
            function = _function_of(design, column, train)
            acting = None if function is None else _over_range(function, design, records, column)
            if acting is not None and acting.is_invertible:
                found[column] = acting
    return [acting_through(record, found) for record in records]


def _function_of(design: Design, column: int, train: Sequence[Record]) -> Sum | None:
    """Return the function of an input that the model has; None if it is the input itself."""
    place = len(design.states) + column
    parts = {_factors_of(term, place) for _, term in _terms(design) if place in term.variables}
    if not parts or None in parts or all(part is not None and part.size == 1 for part in parts):
        return None
    if len(parts) > 1:
        return _fitted_sum(design, place, train)
    return Sum(tuple((1.0, part) for part in parts if part is not None))


def _terms(design: Design) -> Iterator[tuple[int, Product]]:
    for state in range(len(design.states)):
        for term in design.terms_of(state):
            yield state, term


def _factors_of(term: Product, place: int) -> Product | None:
    """Return the factors of a term that depend on one variable; None if one depends on more."""
    of_variable = [(atom, power) for atom, power in term.factors if place in atom.variables]
    is_single = all(atom.variables == {place} for atom, _ in of_variable)
    return Product(tuple(of_variable)) if is_single else None


def _fitted_sum(design: Design, place: int, train: Sequence[Record]) -> Sum | None:
    """Return the fitted sum of all functions of an input.

    None unless they stand in one equation, and all have the same other factors.
    """
    acting = [(state, term) for state, term in _terms(design) if place in term.variables]
    states = {state for state, _ in acting}
    if len(states) > 1 or len({_other_factors(term, place) for _, term in acting}) > 1:
        return None
    (state,) = states
    rows = rows_of(train)
    rates = np.concatenate([record.x_dot[:, state] for record in train])
    sides = [column.parts[state] for column in design.columns if column.parts[state].parts]
    theta = np.array([side.evaluate(rows) for side in sides]).reshape(len(sides), len(rows)).T
    known_rates = design.known(rows)[:, state]
    has_value = np.isfinite(theta).all(axis=1) & np.isfinite(known_rates)
    coef = np.linalg.lstsq(theta[has_value], (rates - known_rates)[has_value], rcond=None)[0]
    total = design.fixed[state]
    for value, side in zip(coef.tolist(), sides, strict=True):
        total = add(total, mul(constant(value), side))
    parts = ((c, _factors_of(term, place)) for c, term in total.parts)
    return Sum(tuple((c, part) for c, part in parts if part is not None and part.factors))


def _other_factors(term: Product, place: int) -> Product:
    """Return the factors of a term that do not depend on a variable."""
    return Product(tuple(factor for factor in term.factors if place not in factor[0].variables))


def _over_range(
    function: Sum, design: Design, records: Sequence[Record], column: int
) -> InputFunction:
    values = np.concatenate([record.recorded_u[:, column] for record in records])
    acts = _Acts(function, len(design.states) + column)
    return InputFunction(acts, float(values.min()), float(values.max()))


@dataclass(frozen=True)
class _Acts:
    """An expression of a single input as a function of its values; it can be pickled."""

    expression: Sum
    place: int

    def __call__(self, u: np.ndarray) -> np.ndarray:
        variables = np.zeros((len(u), self.place + 1))
        variables[:, self.place] = u
        return self.expression.evaluate(variables)
