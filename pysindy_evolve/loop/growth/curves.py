"""Curves with a number or two that no product of operators is, and lengths of vectors.

A law of nature is often one of them: pipes rub with |v|^1.75, a gene answers with x^n/(c^n + x^n),
a substrate inhibits its own uptake, a wing stalls at an angle, the drag of a body depends on the
length of its velocity. A genetic search seldom hits such numbers, so the factors of a grown term
are exchanged for these curves afterwards.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import reduce
from itertools import combinations, product

import numpy as np

from ...operators import BUILTIN, Operator
from ...terms import Sum, add, call, constant, mul, power, sub, variable

EXPONENTS = (0.3, 0.7, 1.5, 2.5)  # of powers; whole ones and the root are products of operators
HILL_EXPONENTS = (2.0, 4.0)
LEVELS = (0.15, 0.35, 0.5, 0.65, 0.85)  # places within the range of a variable, as shares of it
WIDTHS = (0.1, 0.3)  # of steps, as shares of the range
FARTHEST = 2.0  # places of steps, over the range: tanh(2.5 T - 752) has no number that can be tuned
SCALES = (0.5, 1.0, 2.0)  # levels of a Hill function, over the RMS of its variable
INHIBITION = ((0.2, 0.5), (0.2, 2.0), (0.6, 2.0))  # levels of half a rate and of its inhibition
MOST_AXES = 3  # of a vector
NEEDED = {"mul", "exp", "log", "abs", "tanh", "div", "softsign", "sqrt"}


def curves(operators: Sequence[Operator], x: np.ndarray, n_states: int) -> list[Sum]:
    """Return powers, Hill functions, inhibited rates, steps and lengths.

    Parameters
    ----------
    operators : sequence of Operator
        Basis functions: without those of the default there are no curves.
    x : ndarray of shape (n, n_variables)
        Variables, the states first; their ranges set the numbers in the curves.
    n_states : int
        Number of states. Two or three of them may be a vector.

    Returns
    -------
    list of Sum
    """
    if not {operator.name for operator in operators} >= NEEDED:
        return []
    varying = [i for i, column in enumerate(x.T) if np.ptp(column) > 0.0]
    found = [curve for i in varying for curve in (*_rates(i, x[:, i]), *_places(i, x[:, i]))]
    states = [variable(i) for i in varying if i < n_states]
    vectors = (v for n in range(2, MOST_AXES + 1) for v in combinations(states, n))
    return [*found, *map(_length, vectors)]


def _rates(i: int, column: np.ndarray) -> Iterator[Sum]:
    """Yield powers of a variable, and rates that saturate or are inhibited with it."""
    x, size = variable(i), float(np.sqrt(np.mean(column**2)))
    magnitude, is_positive = call(BUILTIN["abs"], x), column.min() > 0.0
    yield from (_power(x if is_positive else magnitude, exponent) for exponent in EXPONENTS)
    for n, scale in product(HILL_EXPONENTS, SCALES):
        level = (scale * size) ** -n
        yield call(BUILTIN["softsign"], mul(constant(level), _power(magnitude, n)))
    for half, inhibited in INHIBITION if is_positive else ():
        square = mul(constant(1.0 / (inhibited * size)), power(x, 2))
        yield mul(x, power(add(constant(half * size), add(x, square)), -1))


def _places(i: int, column: np.ndarray) -> Iterator[Sum]:
    """Yield steps at places within the range of a variable, unless that is far from zero."""
    x, low, span = variable(i), float(column.min()), float(np.ptp(column))
    for place in (low + share * span for share in LEVELS):
        for width in (share * span for share in WIDTHS if abs(place) < FARTHEST * span):
            yield call(BUILTIN["tanh"], mul(constant(1.0 / width), sub(x, constant(place))))


def _power(magnitude: Sum, exponent: float) -> Sum:
    """Return a power of what is not negative."""
    return call(BUILTIN["exp"], mul(constant(exponent), call(BUILTIN["log"], magnitude)))


def _length(axes: Sequence[Sum]) -> Sum:
    return call(BUILTIN["sqrt"], reduce(add, (power(axis, 2) for axis in axes)))
