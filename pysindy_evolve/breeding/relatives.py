"""Simple products that may replace a term with a sum inside.

For small q, 1/(q + sgn(v)) is about sgn(v) - q + q^2 sgn(v). So beside sgn(v) and q it fits as
well as q^2 sgn(v), which the search then has no reason to breed. Where an equation holds a term
with a sum inside, the products of its atoms are offered too, and the cheaper term stays.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations_with_replacement

from ..operators import Operator
from ..terms import ONE, Atom, Call, Product, Sum, Variable, as_sum, constant, mul, only_atom
from .genetics import is_even_power_of_sgn

DEGREE = 3  # atoms in a product, as in q^2 sgn(v) or in a cubic spring
MOST_ATOMS = 6  # they make 83 products; an equation with more atoms has not settled yet


def product_alternatives(
    equation: Sequence[Product], operators: Sequence[Operator]
) -> list[Product]:
    """Return the products of the atoms of an equation, if one of its terms has a sum inside.

    Parameters
    ----------
    equation : sequence of Product
        Terms of the best equation so far.
    operators : sequence of Operator
        Basis functions of the search; without ``mul`` there are no products.

    Returns
    -------
    list of Product
        Products of up to three variables and calls of one variable; empty if no term of the
        equation has a sum inside.
    """
    if not any(operator.name == "mul" for operator in operators):
        return []
    if not any(_has_sum(term) for term in equation):
        return []
    atoms = list(dict.fromkeys(atom for term in equation for atom in _simple_atoms(term)))
    found: dict[Product, None] = {}
    for degree in range(1, DEGREE + 1):
        for chosen in combinations_with_replacement(atoms[:MOST_ATOMS], degree):
            product = constant(1.0)
            for atom in chosen:
                product = mul(product, as_sum(atom))
            found.update((term, None) for _, term in product.parts if not _is_trivial(term))
    return list(found)


def _has_sum(term: Product) -> bool:
    return any(
        isinstance(atom, Sum)
        or (isinstance(atom, Call) and any(not _is_variable(a) for a in atom.args))
        for atom, _ in term.factors
    )


def _simple_atoms(term: Product) -> Iterator[Atom]:
    """Yield variables and calls of one variable; sgn(q + v) yields q, v, sgn(q) and sgn(v)."""
    for atom, _ in term.factors:
        if isinstance(atom, Variable) or (isinstance(atom, Call) and _of_variables(atom)):
            yield atom
            continue
        sums = atom.args if isinstance(atom, Call) else (atom,)
        inner = [a for total in sums for _, part in total.parts for a in _simple_atoms(part)]
        yield from inner
        if isinstance(atom, Call) and atom.operator.arity == 1:
            yield from (Call(atom.operator, (as_sum(a),)) for a in inner if isinstance(a, Variable))


def _of_variables(call: Call) -> bool:
    return all(_is_variable(argument) for argument in call.args)


def _is_variable(argument: Sum) -> bool:
    return isinstance(only_atom(argument), Variable)


def _is_trivial(term: Product) -> bool:
    """Tell whether a term is 1, or has a factor that is 1 except at zero."""
    return term == ONE or any(map(is_even_power_of_sgn, term.factors))
