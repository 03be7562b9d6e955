"""Small terms that a search begins with, as its random ones seldom hold all of them.

A root of the speed with its sign is one of some hundred products of two functions of one variable.
All of them are looked at one by one, beside the declared terms times one such function, and those
that explain most begin the search.

References
----------
Fan and Lv, J. R. Stat. Soc. B 70 (2008), DOI 10.1111/j.1467-9868.2008.00674.x: such screening.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations_with_replacement

import numpy as np

from ...breeding.dictionary import Problem, build_dictionary
from ...breeding.poles import is_away
from ...operators import SCALED, Operator
from ...sparse.elimination import gains
from ...terms import (
    Product,
    Sum,
    Variable,
    add,
    as_product,
    call,
    constant,
    mul,
    power,
    sub,
    variable,
)

__all__ = ["functions", "screened", "small_terms", "varied"]

SCALES = (0.5, 1.0, 3.0)  # numbers in a curved function, over the size of the variable
GAPS = (0.3, 1.0, 3.0)  # distances of a pole to the range of a variable, over that range
CHUNK = 200  # terms that are evaluated at a time, so that memory does not grow with them


def small_terms(operators: Sequence[Operator], x: np.ndarray) -> list[Product]:
    """Return all products of two functions of one variable, of which one at most is curved.

    Parameters
    ----------
    operators : sequence of Operator
        Basis functions; without ``mul`` there are no products.
    x : ndarray of shape (n, n_variables)
        Variables; their sizes set the numbers in curved functions.

    Returns
    -------
    list of Product
    """
    straight, curved = _of_one_variable(operators, x)
    found = [*straight, *curved]
    if any(operator.name == "mul" for operator in operators):
        found += [mul(a, b) for a, b in combinations_with_replacement(straight, 2)]
        found += [mul(a, b) for a in straight for b in curved]
    terms = (term for one in found for _, term in one.parts)
    return list(dict.fromkeys(term for term in terms if term.variables))


def varied(
    declared: Sequence[Product], operators: Sequence[Operator], x: np.ndarray
) -> list[Product]:
    """Return declared terms times a function of one variable, or the square of one; and rationals.

    A model that somebody wrote down is mostly right: what it lacks is often that a force, such as
    the thrust T cos(theta) near the ground, depends on one thing more. What pulls across a gap, or
    is inhibited by what there is too much of, has that below the line; it may also be missing
    altogether, by itself or times a variable, as what y predators catch of prey that hides.

    Parameters
    ----------
    declared : sequence of Product
        Terms of one equation. Those of the time, and constants, are passed over.
    operators : sequence of Operator
        Basis functions; without ``mul`` there are no products.
    x : ndarray of shape (n, n_variables)
        Measured variables, without the time.

    Returns
    -------
    list of Product
    """
    if not any(operator.name == "mul" for operator in operators):
        return []
    measured = frozenset(range(x.shape[1]))
    able = (term for term in declared if term.variables and term.variables <= measured)
    wholes = [Sum(((1.0, term),)) for term in able]
    straight, _ = _of_one_variable(operators, x)
    squares = [power(f, 2) for f in straight if _is_power(f)]  # of a sign or a root: nothing new
    distant = list(_distant({operator.name: operator for operator in operators}, x))
    alone = (constant(1.0), *(variable(i) for i in range(x.shape[1])))
    products = [mul(whole, factor) for whole in wholes for factor in (*straight, *squares)]
    products += [mul(whole, factor) for whole in (*wholes, *alone) for factor in distant]
    found = dict.fromkeys(term for product in products for _, term in product.parts)
    return [term for term in found if term.variables and term not in declared]


def functions(operators: Sequence[Operator], x: np.ndarray) -> list[Sum]:
    """Return all functions of one variable that small terms are products of.

    Parameters
    ----------
    operators : sequence of Operator
        Basis functions.
    x : ndarray of shape (n, n_variables)
        Variables; their sizes set the numbers in curved functions.

    Returns
    -------
    list of Sum
    """
    straight, curved = _of_one_variable(operators, x)
    return [*straight, *curved]


def screened(problem: Problem, terms: Sequence[Product], n: int) -> list[Product]:
    """Return the `n` terms that explain most, each by itself beside the fixed columns.

    Parameters
    ----------
    problem : Problem
        Variables, target and fixed columns.
    terms : sequence of Product
        Terms to choose from; of those that are one signal the smallest counts.
    n : int
        Number to return, best first.

    Returns
    -------
    list of Product
    """
    chunks = [terms[i : i + CHUNK] for i in range(0, len(terms), CHUNK)]
    best = [term for chunk in chunks for term in _best(problem, chunk, n)]
    return _best(problem, best, n)


def _best(problem: Problem, terms: Sequence[Product], n: int) -> list[Product]:
    dictionary = build_dictionary(problem, terms)
    left, _ = gains(dictionary.gram.scaled(dictionary.gram.scale), np.array([], dtype=int))
    return [dictionary.terms[j] for j in np.argsort(left, kind="stable")[:n]]


def _of_one_variable(operators: Sequence[Operator], x: np.ndarray) -> tuple[list[Sum], list[Sum]]:
    straight = [f for i, column in enumerate(x.T) for f in _straight(operators, i, column)]
    curved = [
        f
        for i, size in enumerate(np.sqrt(np.mean(x**2, axis=0)))
        for f in _curved(operators, variable(i), float(size))
    ]
    return straight, curved


def _is_power(f: Sum) -> bool:
    ((atom, _),) = as_product(f).factors
    return isinstance(atom, Variable)


def _straight(operators: Sequence[Operator], i: int, column: np.ndarray) -> Iterator[Sum]:
    """Go through functions without a scale of their own; a root is one of the magnitude.

    Magnitude and sign of what keeps its sign are nothing new, and only what keeps away from zero
    can stand below the line, or in a logarithm.
    """
    known, x = {operator.name: operator for operator in operators}, variable(i)
    yield x
    if "log" in known and column.min() > 0.0:
        yield call(known["log"], x)
    if column.min() < 0.0 < column.max():
        yield from (call(known[name], x) for name in ("abs", "sgn") if name in known)
    elif "div" in known and is_away(column):
        yield power(x, -1)
    if {"abs", "sqrt"} <= known.keys():
        yield call(known["sqrt"], call(known["abs"], x))


def _distant(known: Mapping[str, Operator], x: np.ndarray) -> Iterator[Sum]:
    """Go through functions of how far away a place out of range is, or one beside the line."""
    if "div" in known:
        yield from _below_the_line(x)
    if {"div", "sqrt"} <= known.keys():
        yield from (power(call(known["sqrt"], length), -1) for _, length in _squares_away(x))
    if "log" in known:
        yield from (call(known["log"], away) for away in _distances(x))


def _below_the_line(x: np.ndarray) -> Iterator[Sum]:
    """Go through reciprocals of a distance to a place out of range, and of what saturates."""
    for away in _distances(x):
        yield from (power(away, -1), power(away, -2))
    for square, away in _squares_away(x):
        yield from (power(away, -1), mul(square, power(away, -1)))


def _squares_away(x: np.ndarray) -> Iterator[tuple[Sum, Sum]]:
    """Go through squares of variables, each with itself plus that of a constant at several scales.

    The root of the sum is a length: that of a spring whose end moves beside it.
    """
    for i, column in enumerate(x.T):
        square, size = power(variable(i), 2), float(np.mean(column**2))
        if size > 0.0:
            yield from ((square, add(constant(scale**2 * size), square)) for scale in SCALES)


def _distances(x: np.ndarray) -> Iterator[Sum]:
    """Go through distances of a variable to places out of its range, all of them positive."""
    for i, column in enumerate(x.T):
        low, high = float(column.min()), float(column.max())
        for gap in (share * (high - low) for share in GAPS):
            if is_away(column - low + gap):
                yield sub(variable(i), constant(low - gap))
            if is_away(column - high - gap):
                yield sub(constant(high + gap), variable(i))


def _curved(operators: Sequence[Operator], x: Sum, size: float) -> Iterator[Sum]:
    """Go through curved functions at several scales; what decays is no multiple of what grows."""
    if size > 0.0:
        for operator in operators:
            if operator.name in SCALED:
                signs = (1.0, -1.0) if operator.name == "exp" else (1.0,)
                scales = [sign * c / size for sign in signs for c in SCALES]
                yield from (call(operator, mul(constant(c), x)) for c in scales)
