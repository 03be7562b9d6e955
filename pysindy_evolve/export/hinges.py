"""What begins at a place, written as max(q - c, 0), and what ends at two, as min(max(u, -c), c).

So stops, overflows and saturations are read. The rest of the package knows them as magnitudes, such
as k |q - c| beside k q and a constant, whose parts go into other terms of an equation.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce
from itertools import permutations, product

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
    sub,
)

__all__ = ["as_hinges"]

MIN = Operator("min", np.minimum, 2, sympy.Min)
MAX = Operator("max", np.maximum, 2, sympy.Max)
MOST = 4  # magnitudes of one sum, each of which may be a hinge to either side
ROUNDING = 1e-9  # of what cancels

_Kink = tuple[float, Product, Sum]  # its weight, the term, and what it is the magnitude of


def as_hinges(side: Sum) -> Sum:
    """Return a sum for reading, in which magnitudes are hinges where that leaves less, or limits.

    Parameters
    ----------
    side : Sum
        Right-hand side, multiplied out.

    Returns
    -------
    Sum
        Equal to it, with fewer terms or flatter straight ones; c |u - a| - c |u - b| is a limit.

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
    side = _rooted(Sum(tuple((weight, _inside(term)) for weight, term in side.parts)))
    kinks = _kinks(side)
    if not 0 < len(kinks) <= MOST:
        return side
    forms = [_folded(side, kinks, ways) for ways in product((0, 1, -1), repeat=len(kinks))]
    return _limited(min(forms, key=_weight))  # of equal ones the first, in which least is folded


def _inside(term: Product) -> Product:
    """Return a term with what is inside of its functions written with hinges."""
    return Product(
        tuple(
            (Call(atom.operator, tuple(map(as_hinges, atom.args))), exponent)
            if isinstance(atom, Call)
            else (atom, exponent)
            for atom, exponent in term.factors
        )
    )


def _rooted(side: Sum) -> Sum:
    """Write c sqrt(|a|) + c sqrt(|a|) sgn(a) as 2 c sqrt(max(a, 0)); so for all powers of |a|."""
    weights = {term: weight for weight, term in side.parts}
    for term, weight in weights.items():
        for atom, n in term.factors:
            if not isinstance(atom, Call) or (atom.operator.name, n) != ("sgn", 1):
                continue
            plain = Product(tuple(factor for factor in term.factors if factor[0] != atom))
            if abs(weights.get(plain, 0.0)) != abs(weight):
                continue
            size = as_sum(Call(BUILTIN["abs"], atom.args))
            beyond = mul(constant(np.sign(weight * weights[plain])), atom.args[0])
            above = as_sum(Call(MAX, (beyond, Sum(()))))
            roots = ((factor, _root_of(factor, size, above)) for factor in plain.factors)
            factor, hinge = next((one for one in roots if one[1] is not None), (None, None))
            if hinge is None:
                continue
            rest = Product(tuple(other for other in plain.factors if other != factor))
            left = tuple(part for part in side.parts if part[1] not in (term, plain))
            return _rooted(Sum((*left, (2.0 * weights[plain], _times(rest, hinge)))))
    return side


def _root_of(factor: tuple[Atom, int], size: Sum, above: Sum) -> Call | None:
    """Return a root or power of a magnitude with something in its place; None of other factors."""
    atom, n = factor
    if n != 1 or not isinstance(atom, Call):
        return None
    root, log = BUILTIN["sqrt"], as_sum(Call(BUILTIN["log"], (size,)))
    if atom == Call(root, (size,)):
        return Call(root, (above,))
    if atom.operator != BUILTIN["exp"] or len(atom.args[0].parts) != 1:
        return None
    ((exponent, term),) = atom.args[0].parts
    if exponent <= 0.0 or term != only_term(log):
        return None
    return Call(atom.operator, (mul(constant(exponent), as_sum(Call(BUILTIN["log"], (above,)))),))


def _kinks(side: Sum) -> list[_Kink]:
    found = ((weight, term, _kink_of(term)) for weight, term in side.parts)
    return [(weight, term, away) for weight, term, away in found if away is not None]


def _kink_of(term: Product) -> Sum | None:
    """Return what a term has the magnitude of as a factor: variables, and maybe a number."""
    calls = [(atom, n) for atom, n in term.factors if isinstance(atom, Call)]
    if [(atom.operator.name, n) for atom, n in calls] != [("abs", 1)]:
        return None
    (away,) = calls[0][0].args
    return away if all(inner.size == 1 for _, inner in away.parts) else None


def _besides(term: Product) -> Product:
    """Return a term without its function."""
    return Product(tuple(factor for factor in term.factors if not isinstance(factor[0], Call)))


def _folded(side: Sum, kinks: Sequence[_Kink], ways: Sequence[int]) -> Sum:
    """Write c |a| as 2 c max(a, 0) - c a, or as 2 c max(-a, 0) + c a, or as it is, for each way."""
    hinges = []
    for (weight, term, away), way in zip(kinks, ways, strict=True):
        if way:
            beyond = mul(constant(way), away)
            rest = _besides(term)
            hinges.append((2.0 * weight, _times(rest, Call(MAX, (beyond, Sum(()))))))
            straight = mul(Sum(((-weight, rest),)), beyond)
            side = _sum([side, straight, Sum(((-weight, term),))])
    return Sum((*side.parts, *hinges))


def _limited(side: Sum) -> Sum:
    """Write c |x - a| - c |x - b| as 2 c min(max(x, a), b) - c (a + b), unless that leaves more."""
    for (one, above, high), (other, below, low) in permutations(_kinks(side), 2):
        apart = sub(low, high)  # b - a
        are_ends = [term for _, term in apart.parts] == [ONE] and apart.parts[0][0] > 0.0
        if are_ends and one == -other and _besides(above) == _besides(below):
            x = Sum(tuple(part for part in low.parts if part[1] != ONE))
            ends = [sub(x, low), sub(x, high)]
            limit = Call(MIN, (as_sum(Call(MAX, (x, ends[0]))), ends[1]))
            rest, weight = _besides(below), constant(-other)
            straight = mul(mul(weight, add(*ends)), of_term(rest))
            gone = [Sum(((-one, above),)), Sum(((-other, below),))]
            left = _sum([side, straight, *gone])
            shown = Sum((*left.parts, (2.0 * other, _times(rest, limit))))
            if len(shown.parts) <= len(side.parts):
                return _limited(shown)
    return side


def _times(rest: Product, function: Call) -> Product:
    return Product((*rest.factors, (function, 1)))


def _sum(sides: Sequence[Sum]) -> Sum:
    """Add sides up, without what only rounding leaves."""
    total = reduce(add, sides)
    largest: dict[Product, float] = {}
    for weight, term in (part for side in sides for part in side.parts):
        largest[term] = max(largest.get(term, 0.0), abs(weight))
    return Sum(tuple((w, term) for w, term in total.parts if abs(w) > ROUNDING * largest[term]))


def _weight(side: Sum) -> tuple[int, int, float]:
    """Return the number of terms, of hinges at zero, and how steep those without a function are.

    A friction -2 v - |v| shall not read as -v - 2 max(v, 0).
    """
    plain = (w for w, term in side.parts if term != ONE and not _has_function(term))
    return len(side.parts), _n_at_zero(side), sum(abs(weight) for weight in plain)


def _n_at_zero(side: Sum) -> int:
    hinges = (atom for _, term in side.parts for atom, _ in term.factors if isinstance(atom, Call))
    inside = (hinge.args[0] for hinge in hinges if hinge.operator == MAX)
    return sum(all(term != ONE for _, term in one.parts) for one in inside)


def _has_function(term: Product) -> bool:
    return any(isinstance(atom, Call) for atom, _ in term.factors)
