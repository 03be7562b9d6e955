"""Through which function the declared model takes an input that jumps."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from ...signals import Record
from ...signals.acting import InputFunction
from ...signals.holds import acting_through
from ...terms import Product
from .design import Design
from .input_errors import is_held

__all__ = ["with_functions"]


def with_functions(design: Design, records: Sequence[Record]) -> list[Record]:
    """Return records whose inputs have the functions that act, after the low-pass.

    Parameters
    ----------
    design : Design
        The declared model.
    records : sequence of Record
        Training and held-out ones.

    Returns
    -------
    list of Record
        Changed are inputs that jump, and stand in the model in one and the same function.
    """
    found = {}
    for column in range(len(design.inputs)):
        product = _function_of(design, column)
        if product is not None and all(is_held(record, column) for record in records):
            one = _over_range(product, len(design.states) + column, records, column)
            if one.is_invertible:
                found[column] = one
    return [acting_through(record, found) for record in records]


def _function_of(design: Design, column: int) -> Product | None:
    """Return the one function of an input that the model has; None if it is the input itself."""
    place = len(design.states) + column
    found = {_part(term, place) for term in _terms(design) if place in term.variables}
    if len(found) != 1:
        return None
    (part,) = found
    return None if part is None or part.size == 1 else part


def _terms(design: Design) -> Iterator[Product]:
    for state in range(len(design.states)):
        yield from design.terms_of(state)


def _part(term: Product, place: int) -> Product | None:
    """Return the factors of a term that are functions of one variable; None if one is of more."""
    own = [(atom, power) for atom, power in term.factors if place in atom.variables]
    alone = all(atom.variables == {place} for atom, _ in own)
    return Product(tuple(own)) if alone else None


def _over_range(
    product: Product, place: int, records: Sequence[Record], column: int
) -> InputFunction:
    def function(u: np.ndarray) -> np.ndarray:
        variables = np.zeros((len(u), place + 1))
        variables[:, place] = u
        return product.evaluate(variables)

    values = np.concatenate([record.recorded_u[:, column] for record in records])
    return InputFunction(function, float(values.min()), float(values.max()))
