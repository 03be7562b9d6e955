"""Small terms that a genetic search starts from, as random ones seldom include them all.

For example, sqrt(|v|) sgn(v) is one of some hundred products of two functions of one variable.
Each of these, and each declared term times one such function, is scored alone. Those that explain
most start the search.

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

SCALES = (0.5, 1.0, 3.0)  # numbers in a function, scaled by the RMS of its variable (dimensionless)
GAPS = (0.3, 1.0, 3.0)  # distances of a pole from the range of a variable, as shares of that range
CHUNK = 200  # terms evaluated at a time, to bound the memory


def small_terms(operators: Sequence[Operator], x: np.ndarray) -> list[Product]:
    """Return functions of one variable and products of two, of which at most one is curved.

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
    terms = (term for expression in found for _, term in expression.parts)
    return list(dict.fromkeys(term for term in terms if term.variables))


def varied(
    declared: Sequence[Product], operators: Sequence[Operator], x: np.ndarray
) -> list[Product]:
    """Return declared terms times a function of one variable or its square, and rational terms.

    A declared model is mostly right: often one of its forces depends on one more variable, such as
    the thrust T cos(theta) near the ground. A pull across a gap, or a rate that an excess inhibits,
    has this variable in the denominator. Such a quotient may also be missing as a whole, alone or
    times a variable, such as what y predators catch of prey that hides.

    Parameters
    ----------
    declared : sequence of Product
        Terms of one equation. Constants and terms of the time are skipped.
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
    usable = (term for term in declared if term.variables and term.variables <= measured)
    bases = [Sum(((1.0, term),)) for term in usable]
    straight, _ = _of_one_variable(operators, x)
    squares = [power(f, 2) for f in straight if _is_power(f)]  # not of signs and roots
    distant = list(_distant({operator.name: operator for operator in operators}, x))
    alone = (constant(1.0), *(variable(i) for i in range(x.shape[1])))
    products = [mul(base, factor) for base in bases for factor in (*straight, *squares)]
    products += [mul(base, factor) for base in (*bases, *alone) for factor in distant]
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
    """Return the `n` terms that explain most, each alone beside the fixed columns.

    Parameters
    ----------
    problem : Problem
        Variables, target and fixed columns.
    terms : sequence of Product
        Terms to choose from; of several with the same signal the smallest is kept.
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
    errors, _ = gains(dictionary.gram.scaled(dictionary.gram.scale), np.array([], dtype=int))
    return [dictionary.terms[j] for j in np.argsort(errors, kind="stable")[:n]]


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
    """Yield functions without a scale; the root is that of the magnitude.

    |x| and sgn(x) are not new where x keeps its sign. 1/x needs an x that stays away from zero,
    log(x) a positive one.
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
    """Yield functions of the distance to a place out of range, or to one off the line of x."""
    if "div" in known:
        yield from _reciprocals(x)
    if {"div", "sqrt"} <= known.keys():
        yield from (power(call(known["sqrt"], length), -1) for _, length in _squares_and_sums(x))
    if "log" in known:
        yield from (call(known["log"], away) for away in _distances(x))


def _reciprocals(x: np.ndarray) -> Iterator[Sum]:
    """Yield reciprocals of distances to places out of range, and quotients that saturate."""
    for away in _distances(x):
        yield from (power(away, -1), power(away, -2))
    for square, away in _squares_and_sums(x):
        yield from (power(away, -1), mul(square, power(away, -1)))


def _squares_and_sums(x: np.ndarray) -> Iterator[tuple[Sum, Sum]]:
    """Yield pairs x^2, c^2 + x^2 for each variable, with several constants c.

    The root of the sum is a length: that of a spring whose end moves sideways.
    """
    for i, column in enumerate(x.T):
        square, size = power(variable(i), 2), float(np.mean(column**2))
        if size > 0.0:
            yield from ((square, add(constant(scale**2 * size), square)) for scale in SCALES)


def _distances(x: np.ndarray) -> Iterator[Sum]:
    """Yield distances of a variable to places out of its range, all of them positive."""
    for i, column in enumerate(x.T):
        low, high = float(column.min()), float(column.max())
        for gap in (share * (high - low) for share in GAPS):
            if is_away(column - low + gap):
                yield sub(variable(i), constant(low - gap))
            if is_away(column - high - gap):
                yield sub(constant(high + gap), variable(i))


def _curved(operators: Sequence[Operator], x: Sum, size: float) -> Iterator[Sum]:
    """Yield curved functions at several scales; exp(-c x) is no multiple of exp(c x)."""
    if size > 0.0:
        for operator in operators:
            if operator.name in SCALED:
                signs = (1.0, -1.0) if operator.name == "exp" else (1.0,)
                scales = [sign * c / size for sign in signs for c in SCALES]
                yield from (call(operator, mul(constant(c), x)) for c in scales)
