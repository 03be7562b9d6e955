"""Fractions in lowest terms: x^4 / (0.5 x^3 + x^4) is x / (0.5 + x), which has a value at zero.

A search works better with the longer forms, whose inner constants may come and go. The shorter form
of its result is easier to read and has values at more places.
"""

from __future__ import annotations

from .arithmetic import as_atom, constant, mul, power
from .products import Product
from .sums import Atom, Sum, as_sum, only_term


def lowest(term: Product) -> Product:
    """Return a term in lowest terms, up to a factor.

    Parameters
    ----------
    term : Product
        Any term.

    Returns
    -------
    Product
        Equal to the given term up to a constant factor.

    Examples
    --------
    >>> from pysindy_evolve.terms import div, add, constant, variable
    >>> x = variable(0)
    >>> term = only_term(div(constant(1.0), add(constant(2.0), power(x, -1))))
    >>> lowest(term).name(["x"])
    'x/(0.5 + x)'
    """
    result = constant(1.0)
    for atom, exponent in term.factors:
        base = atom if isinstance(atom, Sum) else as_sum(atom)
        for other, n in _shared(base) if exponent < 0 and len(base.parts) > 1 else ():
            result = mul(result, power(as_sum(other), n * exponent))
            base = mul(base, power(as_sum(other), -n))
        result = mul(result, power(base, exponent))
    return only_term(as_atom(result))


def _shared(a: Sum) -> tuple[tuple[Atom, int], ...]:
    """Return the powers that all terms of a sum share: x^3 of 0.5 x^3 + x^4, 1/x of 2 + 1/x."""
    powers = [dict(term.factors) for _, term in a.parts]
    atoms = dict.fromkeys(atom for exponents in powers for atom in exponents)
    least = ((atom, min(exponents.get(atom, 0) for exponents in powers)) for atom in atoms)
    return tuple((atom, n) for atom, n in least if n)
