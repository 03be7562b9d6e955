"""Writes magnitudes as hinges, max(q - c, 0), or as limits, min(max(u, -c), c).

So a reader recognizes stops, overflows and saturations. The rest of the package holds them as
magnitudes: k |q - c| beside k q and a constant, which merge with other terms of the equation.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce
from itertools import permutations, product
from typing import TypeGuard

import numpy as np
import sympy

from ..operators import BUILTIN, Operator
from ..terms import (
    ONE,
    Atom,
    Call,
    Product,
    Sum,
    add,
    as_sum,
    constant,
    mul,
    of_term,
    only_term,
    power,
    sub,
)

MIN = Operator("min", np.minimum, 2, sympy.Min)
MAX = Operator("max", np.maximum, 2, sympy.Max)
MOST = 4  # magnitudes of a sum; all 3^4 forms are tried, a hinge to either side or none for each
HIGHEST = 3  # power of a difference that is recognized beside a root of its hinge
STEEPER = 2.0  # where a limit makes the straight terms steeper by more, it is a dead zone
ROUNDING = 1e-9  # of the largest weight of a term; a smaller one is a rounding error

_Kink = tuple[float, Product, Sum]  # weight, term, and argument of its magnitude


def as_hinges(side: Sum) -> Sum:
    """Return a sum for reading, with hinges and limits for magnitudes where that is shorter.

    Parameters
    ----------
    side : Sum
        Right-hand side, multiplied out.

    Returns
    -------
    Sum
        Equal to it, with fewer terms or flatter straight ones; c |u - a| - c |u - b| is a limit.
        More than `MOST` magnitudes stay as they are.

    Examples
    --------
    >>> from pysindy_evolve.operators import BUILTIN
    >>> from pysindy_evolve.terms import call, sub, variable
    >>> q = variable(0)
    >>> beyond = sub(q, constant(0.5))
    >>> stop = mul(constant(10.0), add(beyond, call(BUILTIN["abs"], beyond)))
    >>> stop.name(["q"]), as_hinges(stop).name(["q"])
    ('-5 + 10 q + 10 abs(-0.5 + q)', '20 max(-0.5 + q, 0)')
    >>> both = [call(BUILTIN["abs"], add(q, constant(end))) for end in (2.0, -2.0)]
    >>> as_hinges(sub(*both)).name(["u"])
    '2 min(max(u, -2), 2)'
    """
    side = _powered(_rooted(Sum(tuple((weight, _inside(term)) for weight, term in side.parts))))
    kinks = _kinks(side)
    if not 0 < len(kinks) <= MOST:
        return side
    forms = [_folded(side, kinks, ways) for ways in product((0, 1, -1), repeat=len(kinks))]
    # Of equal ones the first, which is changed least.
    plain, limited = (min(all_, key=_complexity) for all_ in (forms, map(_limited, forms)))
    keeps_slope = _slope(limited, plain) <= STEEPER * _slope(plain, limited)
    return limited if keeps_slope else _limited(plain)


def _inside(term: Product) -> Product:
    """Return a term with the arguments of its functions written with hinges."""
    return Product(
        tuple(
            (Call(atom.operator, tuple(map(as_hinges, atom.args))), exponent)
            if isinstance(atom, Call)
            else (atom, exponent)
            for atom, exponent in term.factors
        )
    )


def _rooted(side: Sum) -> Sum:
    """Write c sqrt(|a|) + c sqrt(|a|) sgn(a) as 2 c sqrt(max(a, 0)), and so all powers of |a|."""
    weights = {term: weight for weight, term in side.parts}
    for term, weight in weights.items():
        for atom, n in term.factors:
            if not isinstance(atom, Call) or (atom.operator.name, n) != ("sgn", 1):
                continue
            plain = Product(tuple(factor for factor in term.factors if factor[0] != atom))
            if abs(weights.get(plain, 0.0)) != abs(weight):
                continue
            magnitude = as_sum(Call(BUILTIN["abs"], atom.args))
            beyond = mul(constant(np.sign(weight * weights[plain])), atom.args[0])
            hinged = as_sum(Call(MAX, (beyond, Sum(()))))
            roots = ((factor, _root_of(factor, magnitude, hinged)) for factor in plain.factors)
            factor, hinge = next((pair for pair in roots if pair[1] is not None), (None, None))
            if hinge is None:
                continue
            rest = Product(tuple(other for other in plain.factors if other != factor))
            others = tuple(part for part in side.parts if part[1] not in (term, plain))
            return _rooted(Sum((*others, (2.0 * weights[plain], _times(rest, hinge)))))
    return side


def _root_of(factor: tuple[Atom, int], magnitude: Sum, hinged: Sum) -> Call | None:
    """Return a root or power of a magnitude with a hinge in its place; None for other factors."""
    atom, n = factor
    if n != 1 or not isinstance(atom, Call):
        return None
    root, log = BUILTIN["sqrt"], as_sum(Call(BUILTIN["log"], (magnitude,)))
    if atom == Call(root, (magnitude,)):
        return Call(root, (hinged,))
    if atom.operator != BUILTIN["exp"] or len(atom.args[0].parts) != 1:
        return None
    ((exponent, term),) = atom.args[0].parts
    if exponent <= 0.0 or term != only_term(log):
        return None
    return Call(atom.operator, (mul(constant(exponent), as_sum(Call(BUILTIN["log"], (hinged,)))),))


def _powered(side: Sum) -> Sum:
    """Write (a - b) sqrt(max(a - b, 0)) as a hinge times its root, which prints as one power."""
    factors = dict.fromkeys(factor for _, term in side.parts for factor in term.factors)
    for factor in factors:
        hinge = _hinge_inside(*factor)
        if hinge is None:
            continue
        having = {part for part in side.parts if factor in part[1].factors}
        beside = {_without(term, factor): weight for weight, term in having}
        others = tuple(part for part in side.parts if part not in having)
        for n in range(1, HIGHEST + 1):
            whole = {term: weight for weight, term in power(hinge.args[0], n).parts}
            ratio = _ratio(beside, whole)
            if ratio is not None:
                return _powered(Sum((*others, (ratio, Product(((hinge, n), factor))))))
    return side


def _hinge_inside(atom: Atom, exponent: int) -> Call | None:
    """Return the hinge of which an atom is the root or a power; None for other atoms."""
    if exponent != 1 or not isinstance(atom, Call) or len(atom.args[0].parts) != 1:
        return None
    ((weight, term),) = atom.args[0].parts
    if len(term.factors) != 1 or term.factors[0][1] != 1:
        return None
    inner = term.factors[0][0]
    if atom.operator == BUILTIN["exp"] and isinstance(inner, Call) and weight > 0.0:
        return _hinge_inside(inner, 1) if inner.operator == BUILTIN["log"] else None
    is_root = atom.operator in (BUILTIN["sqrt"], BUILTIN["log"]) and weight == 1.0
    is_hinge = isinstance(inner, Call) and inner.operator == MAX
    return inner if is_root and is_hinge and isinstance(inner, Call) else None


def _without(term: Product, factor: tuple[Atom, int]) -> Product:
    return Product(tuple(other for other in term.factors if other != factor))


def _ratio(weights: dict[Product, float], others: dict[Product, float]) -> float | None:
    """Return how many times one sum of terms is another one; None if it is no multiple of it."""
    if weights.keys() != others.keys():
        return None
    ratios = [weights[term] / others[term] for term in weights]
    return ratios[0] if np.ptp(ratios) <= ROUNDING * abs(ratios[0]) else None


def _kinks(side: Sum) -> list[_Kink]:
    found = ((weight, term, _kink_of(term)) for weight, term in side.parts)
    return [(weight, term, argument) for weight, term, argument in found if argument is not None]


def _kink_of(term: Product) -> Sum | None:
    """Return the argument of the only magnitude among the factors: variables, maybe a number."""
    magnitudes = [(atom, n) for atom, n in term.factors if _is_magnitude(atom)]
    if [n for _, n in magnitudes] != [1]:
        return None
    (argument,) = magnitudes[0][0].args
    return argument if all(inner.size == 1 for _, inner in argument.parts) else None


def _is_magnitude(atom: Atom) -> TypeGuard[Call]:
    return isinstance(atom, Call) and atom.operator.name == "abs"


def _besides(term: Product) -> Product:
    """Return a term without its magnitude."""
    return Product(tuple(factor for factor in term.factors if not _is_magnitude(factor[0])))


def _folded(side: Sum, kinks: Sequence[_Kink], ways: Sequence[int]) -> Sum:
    """Write c |a| as 2 c max(a, 0) - c a, as 2 c max(-a, 0) + c a, or as it is: ways 1, -1, 0."""
    hinges = []
    for (weight, term, argument), way in zip(kinks, ways, strict=True):
        if way:
            beyond = mul(constant(way), argument)
            rest = _besides(term)
            hinges.append((2.0 * weight, _times(rest, Call(MAX, (beyond, Sum(()))))))
            straight = mul(Sum(((-weight, rest),)), beyond)
            side = _sum([side, straight, Sum(((-weight, term),))])
    return Sum((*side.parts, *hinges))


def _limited(side: Sum) -> Sum:
    """Write c |x - a| - c |x - b| as 2 c min(max(x, a), b) - c (a + b), unless that is longer."""
    for (c_high, term_high, high), (c_low, term_low, low) in permutations(_kinks(side), 2):
        width = sub(low, high)  # b - a
        are_ends = [term for _, term in width.parts] == [ONE] and width.parts[0][0] > 0.0
        if are_ends and c_high == -c_low and _besides(term_high) == _besides(term_low):
            x = Sum(tuple(part for part in low.parts if part[1] != ONE))
            ends = [sub(x, low), sub(x, high)]
            limit = Call(MIN, (as_sum(Call(MAX, (x, ends[0]))), ends[1]))
            rest, weight = _besides(term_low), constant(-c_low)
            straight = mul(mul(weight, add(*ends)), of_term(rest))
            removed = [Sum(((-c_high, term_high),)), Sum(((-c_low, term_low),))]
            others = _sum([side, straight, *removed])
            limited = Sum((*others.parts, (2.0 * c_low, _times(rest, limit))))
            if len(limited.parts) <= len(side.parts):
                return _limited(limited)
    return side


def _times(rest: Product, function: Call) -> Product:
    return Product((*rest.factors, (function, 1)))


def _sum(sides: Sequence[Sum]) -> Sum:
    """Add sums, and drop terms that cancel but for rounding."""
    total = reduce(add, sides)
    largest: dict[Product, float] = {}
    for weight, term in (part for side in sides for part in side.parts):
        largest[term] = max(largest.get(term, 0.0), abs(weight))
    return Sum(tuple((w, term) for w, term in total.parts if abs(w) > ROUNDING * largest[term]))


def _complexity(side: Sum) -> tuple[int, int, float]:
    """Return the number of terms, the number of hinges at zero, and the slope of straight terms.

    So a friction -2 v - |v| is not written as -v - 2 max(v, 0).
    """
    return len(side.parts), _n_at_zero(side), _slope(side)


def _slope(side: Sum, other: Sum | None = None) -> float:
    """Return the sum of the weights of straight terms; of those only that another sum has not."""
    common = () if other is None else other.parts
    straight = (part for part in side.parts if part[1] != ONE and not _has_function(part[1]))
    return sum(abs(part[0]) for part in straight if part not in common)


def _n_at_zero(side: Sum) -> int:
    hinges = (atom for _, term in side.parts for atom, _ in term.factors if isinstance(atom, Call))
    inside = (hinge.args[0] for hinge in hinges if hinge.operator == MAX)
    return sum(all(term != ONE for _, term in argument.parts) for argument in inside)


def _has_function(term: Product) -> bool:
    return any(isinstance(atom, Call) for atom, _ in term.factors)
