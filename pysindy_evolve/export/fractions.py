"""Terms over one denominator as one fraction: so the equations of an arm are read and written."""

from __future__ import annotations

from ..terms import Atom, Product, Sum

__all__ = ["as_fractions"]


def as_fractions(side: Sum) -> Sum:
    """Return a sum for reading, in which terms with the same sums below the line are one term.

    Parameters
    ----------
    side : Sum
        Right-hand side, multiplied out.

    Returns
    -------
    Sum
        Equal to it.

    Examples
    --------
    >>> from pysindy_evolve.terms import add, constant, div, power, variable
    >>> q, v = variable(0), variable(1)
    >>> side = add(div(add(q, v), add(constant(1.0), power(q, 2))), v)
    >>> as_fractions(side).name(["q", "v"])
    'v + (q + v)/(1 + q^2)'
    """
    above: dict[tuple[tuple[Atom, int], ...], list[tuple[float, Product]]] = {}
    for coefficient, term in side.parts:
        sums = tuple(one for one in term.factors if isinstance(one[0], Sum) and one[1] < 0)
        rest = Product(tuple(factor for factor in term.factors if factor not in sums))
        above.setdefault(sums, []).append((coefficient, rest))
    parts: list[tuple[float, Product]] = []
    for below, terms in above.items():
        if below and len(terms) > 1:
            parts.append((1.0, Product(((Sum(tuple(terms)), 1), *below))))
        else:
            parts += [(c, Product((*term.factors, *below))) for c, term in terms]
    return Sum(tuple(parts))
