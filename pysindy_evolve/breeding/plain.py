"""Simple terms with one inner constant, such as sin(w x) y, for the first generation.

A random search may try sin(x) y, which explains nothing because its constant is far off, while
products fit nearly as well. So the first generation holds all such terms, with constants on a
coarse grid.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..operators import Operator
from ..terms import ONE, Product, Sum, add, call, constant, div, mul, variable

GRID = (0.5, 1.0, 2.0, 4.0)  # argument of the function where the variable is at its RMS
MAX_TERMS = 400  # terms; more would make the first generation as slow as ten others
# Terms where each generation uses all rows, so that every column is as long as the record.
MAX_TERMS_ON_ALL_ROWS = 80


def plain_terms(
    operators: Sequence[Operator], x: np.ndarray, *, few: bool = False
) -> list[Product]:
    """Return sin(w x), 1/(c + x) and their like, alone and times each variable.

    Parameters
    ----------
    operators : sequence of Operator
        Basis functions of the search; without ``mul`` there are no products.
    x : ndarray of shape (n, n_variables)
        Variables. Reciprocals are made only of those that keep their sign.
    few : bool
        Use one point of the grid, from which tuning starts, and at most `MAX_TERMS_ON_ALL_ROWS`.

    Returns
    -------
    list of Product
        Empty without operators of one argument and without ``add`` and ``div``.
    """
    variables = [variable(i) for i in range(x.shape[1])]
    places = GRID[1:2] if few else GRID
    calls = [*_calls(operators, x, places), *_reciprocals(operators, x, places)]
    has_mul = any(one.name == "mul" for one in operators)
    products = [mul(one, v) for one in calls for v in variables] if has_mul else []
    terms = dict.fromkeys(term for one in [*calls, *products] for _, term in one.parts)
    return [term for term in terms if term != ONE][: MAX_TERMS_ON_ALL_ROWS if few else MAX_TERMS]


def _calls(operators: Sequence[Operator], x: np.ndarray, places: Sequence[float]) -> list[Sum]:
    unary = [operator for operator in operators if operator.arity == 1]
    arguments = [
        mul(constant(sign * place / size), variable(i))
        for i, size in enumerate(sizes(x))
        for place in places
        for sign in (1.0, -1.0)
    ]
    return [call(operator, argument) for operator in unary for argument in arguments]


def _reciprocals(
    operators: Sequence[Operator], x: np.ndarray, places: Sequence[float]
) -> list[Sum]:
    if not {"add", "div"} <= {operator.name for operator in operators}:
        return []
    signs = np.all(x > 0.0, axis=0) - 1.0 * np.all(x < 0.0, axis=0)
    return [
        div(constant(1.0), add(constant(float(sign) * place * size), variable(i)))
        for i, (size, sign) in enumerate(zip(sizes(x), signs, strict=True))
        for place in places
        if sign
    ]


def sizes(x: np.ndarray) -> list[float]:
    """Return the RMS of each variable, 1 where it is zero."""
    size = np.sqrt(np.mean(x**2, axis=0))
    return np.where(size > 0.0, size, 1.0).tolist()
