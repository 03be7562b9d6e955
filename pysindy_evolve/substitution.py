"""Replaces variables by expressions; the result is in canonical form."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import reduce

from .equations import Equations
from .terms import (
    Atom,
    Call,
    Product,
    Sum,
    Variable,
    add,
    call,
    constant,
    mul,
    of_term,
    only_term,
    power,
    variable,
)

Replacements = Mapping[int, Sum] | Mapping[int | Call, Sum]


def substituted(expression: Sum, replacements: Replacements) -> Sum:
    """Return an expression with some of its variables or calls replaced.

    Parameters
    ----------
    expression : Sum
        Its variables are numbered as columns of the data.
    replacements : mapping of int or Call to Sum
        Replacement of a variable, or of a whole call; all others stay.

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


def without_unused_inputs(equations: Equations) -> tuple[Equations, list[int]]:
    """Leave out the inputs that no term depends on.

    Parameters
    ----------
    equations : Equations
        Right-hand sides with any inputs.

    Returns
    -------
    equations : Equations
        The same right-hand sides.
    columns : list of int
        Index of each remaining input among the given ones.
    """
    terms = [equations.terms[i] for i in equations.used]
    first = len(equations.states)
    used = frozenset().union(*(term.variables for term in terms))
    columns = [k for k in range(len(equations.inputs)) if first + k in used]
    places = [*(first + k for k in columns), first + len(equations.inputs)]
    # In the same order as before, so that every term keeps its canonical form.
    moved = {place: variable(first + k) for k, place in enumerate(places)}
    renumbered = tuple(only_term(substituted(of_term(term), moved)) for term in terms)
    names = tuple(equations.inputs[k] for k in columns)
    coef = equations.coef[:, equations.used]
    return replace(equations, terms=renumbered, coef=coef, inputs=names), columns


def _of_product(term: Product, replacements: Replacements) -> Sum:
    factors = (power(_of_atom(atom, replacements), n) for atom, n in term.factors)
    return reduce(mul, factors, constant(1.0))


def _of_atom(atom: Atom, replacements: Replacements) -> Sum:
    if isinstance(atom, Variable):
        return replacements.get(atom.index, variable(atom.index))
    if isinstance(atom, Call):
        whole = replacements.get(atom)  # type: ignore[call-overload]
        if whole is not None:
            return whole
        return call(atom.operator, *(substituted(a, replacements) for a in atom.args))
    return substituted(atom, replacements)
