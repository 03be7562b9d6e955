"""The canonical form of a product: powers collected, sgn and abs simplified."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

from ..operators import BUILTIN
from .atoms import Call
from .products import Product
from .sums import Atom, Sum, collect, only_atom

EXP = BUILTIN["exp"]


def multiply(p: Product, q: Product) -> Product:
    """Return the product of two terms in canonical form."""
    exponents: dict[Atom, int] = dict(p.factors)
    for atom, n in q.factors:
        exponents[atom] = exponents.get(atom, 0) + n
    return simplified(tuple((atom, n) for atom, n in exponents.items() if n))


@lru_cache(maxsize=2**12)  # every twin and every generation makes the same few products
def simplified(factors: tuple[tuple[Atom, int], ...]) -> Product:
    """Apply x sgn(x) = abs(x), abs(x) sgn(x) = x, abs(x)^2 = x^2, sgn(x)^3 = sgn(x); sort.

    Exponentials are joined: exp(x)^2 exp(v) = exp(2 x + v).
    """
    exponents = dict(factors)
    exponentials = [atom for atom in exponents if isinstance(atom, Call) and atom.operator == EXP]
    if len(exponentials) > 1 or any(exponents[atom] != 1 for atom in exponentials):
        _join(exponents, exponentials)
    for atom in list(exponents):
        if isinstance(atom, Call) and atom.operator in (BUILTIN["sgn"], BUILTIN["abs"]):
            _fold(exponents, atom.args[0])
    kept = [(atom, n) for atom, n in exponents.items() if n]
    if len(kept) > 1:
        kept.sort(key=_order)
    return Product(tuple(kept))


def _join(exponents: dict[Atom, int], exponentials: list[Call]) -> None:
    """Replace exponentials and their powers by one exponential of the summed arguments."""
    parts = ((exponents[exp] * c, term) for exp in exponentials for c, term in exp.args[0].parts)
    argument = collect(parts)
    for exp in exponentials:
        del exponents[exp]
    if argument.parts:
        exponents[Call(EXP, (argument,))] = 1


def _fold(exponents: dict[Atom, int], argument: Sum) -> None:
    """Simplify x^n abs(x)^a sgn(x)^s: at most one abs or sgn remains beside a power of x."""
    base: Atom = only_atom(argument) or argument
    sign, magnitude = Call(BUILTIN["sgn"], (argument,)), Call(BUILTIN["abs"], (argument,))
    n, a, s = (exponents.pop(key, 0) for key in (base, magnitude, sign))
    if s < 0:
        exponents.update({base: n, magnitude: a, sign: s})  # 1/sgn(0) has no value: left alone
        return
    odd = (a + s) % 2 == 1  # parity of the sign that is left over
    degree = n + a  # |x|^a = x^a sgn(x)^a
    if degree == 0 and n == 0:
        exponents[sign] = s if s < 2 else 2 - s % 2
        return
    if odd and degree != 0:
        exponents.update({base: degree - 1, magnitude: 1})
    elif odd:
        exponents[sign] = 1
    elif degree:
        exponents[base] = degree


def _order(factor: tuple[Atom, int]) -> tuple[Any, ...]:
    return (*factor[0].key, factor[1])
