"""The plainest terms that hold a number, which no search should have to wait for.

sin(w x) y is one call of one variable times another. A random search may meet sin(x) y, whose
number is far off and which says nothing then, and products fit nearly as well meanwhile. So all
such terms are in the first generation, with numbers on a coarse grid.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..operators import Operator
from ..terms import ONE, Product, Sum, add, call, constant, div, mul, variable

__all__ = ["plain_terms", "sizes"]

GRID = (0.5, 1.0, 2.0, 4.0)  # argument of a function at the typical size of a variable
MOST = 400  # of many variables and functions, so that one generation does not take as long as ten
FEW = 80  # where all rows are used, and each term takes up as much memory as all of them


def plain_terms(
    operators: Sequence[Operator], x: np.ndarray, *, few: bool = False
) -> list[Product]:
    """Return sin(w x), 1/(c + x) and their like, alone and times each variable.

    Parameters
    ----------
    operators : sequence of Operator
        Basis functions of the search; without ``mul`` there are no products.
    x : ndarray of shape (n, n_variables)
        Variables. Of those that change their sign there are no reciprocals.
    few : bool
        Whether one place of the grid must do, which tuning leaves, and not all products are needed.

    Returns
    -------
    list of Product
        Empty where no function takes one argument, and none divides.
    """
    variables = [variable(i) for i in range(x.shape[1])]
    places = GRID[1:2] if few else GRID
    calls = [*_calls(operators, x, places), *_reciprocals(operators, x, places)]
    multiplied = any(one.name == "mul" for one in operators)
    products = [mul(one, v) for one in calls for v in variables] if multiplied else []
    terms = dict.fromkeys(term for one in [*calls, *products] for _, term in one.parts)
    return [term for term in terms if term != ONE][: FEW if few else MOST]


def _calls(operators: Sequence[Operator], x: np.ndarray, places: Sequence[float]) -> list[Sum]:
    unary = [one for one in operators if one.arity == 1]
    arguments = [
        mul(constant(sign * place / size), variable(i))
        for i, size in enumerate(sizes(x))
        for place in places
        for sign in (1.0, -1.0)
    ]
    return [call(one, argument) for one in unary for argument in arguments]


def _reciprocals(
    operators: Sequence[Operator], x: np.ndarray, places: Sequence[float]
) -> list[Sum]:
    if not {"add", "div"} <= {one.name for one in operators}:
        return []
    one_way = np.all(x > 0.0, axis=0) - 1.0 * np.all(x < 0.0, axis=0)
    return [
        div(constant(1.0), add(constant(float(way) * place * size), variable(i)))
        for i, (size, way) in enumerate(zip(sizes(x), one_way, strict=True))
        for place in places
        if way
    ]


def sizes(x: np.ndarray) -> list[float]:
    """Return the RMS of each variable, one where it is zero."""
    size = np.sqrt(np.mean(x**2, axis=0))
    return np.where(size > 0.0, size, 1.0).tolist()
