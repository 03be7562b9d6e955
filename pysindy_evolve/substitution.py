"""Put expressions in the place of variables; the result is in its one form again."""

from __future__ import annotations

from collections.abc import Mapping
from functools import reduce

from .terms import Atom, Call, Product, Sum, Variable, add, call, constant, mul, power, variable

__all__ = ["substituted"]


def substituted(expression: Sum, replacements: Mapping[int, Sum]) -> Sum:
    """Return an expression with some of its variables replaced.

    Parameters
    ----------
    expression : Sum
        Of variables, numbered as columns of the data.
    replacements : mapping of int to Sum
        What stands for a variable; the others stay.

    Returns
    -------
    Sum

    Examples
    --------
    >>> from pysindy_evolve.terms import mul, variable
    >>> product = mul(variable(0), variable(1))
    >>> substituted(product, {1: add(variable(2), constant(3.0))}).name(("a", "b", "c"))
    '3 a + a c'
    """
    parts = (mul(constant(c), _of_product(term, replacements)) for c, term in expression.parts)
    return reduce(add, parts, Sum(()))


def _of_product(term: Product, replacements: Mapping[int, Sum]) -> Sum:
    factors = (power(_of_atom(atom, replacements), n) for atom, n in term.factors)
    return reduce(mul, factors, constant(1.0))


def _of_atom(atom: Atom, replacements: Mapping[int, Sum]) -> Sum:
    if isinstance(atom, Variable):
        return replacements.get(atom.index, variable(atom.index))
    if isinstance(atom, Call):
        return call(atom.operator, *(substituted(a, replacements) for a in atom.args))
    return substituted(atom, replacements)
