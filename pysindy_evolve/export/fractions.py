"""Terms with the same denominator as one fraction, as the equations of a robot arm are written."""

from __future__ import annotations

from ..terms import ONE, Atom, Call, Product, Sum

__all__ = ["as_fractions"]


def as_fractions(side: Sum) -> Sum:
    """Return a sum for reading, in which terms with the same sums in the denominator are one.

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
    numerators: dict[tuple[tuple[Atom, int], ...], list[tuple[float, Product]]] = {}
    for coefficient, term in side.parts:
        sums = tuple(power for power in term.factors if isinstance(power[0], Sum) and power[1] < 0)
        rest = Product(tuple(factor for factor in term.factors if factor not in sums))
        numerators.setdefault(sums, []).append((coefficient, rest))
    parts: list[tuple[float, Product]] = []
    for sums, numerator in numerators.items():
        denominator, scale = _about_one(sums)
        terms = [(c / scale, term) for c, term in numerator]
        if denominator and len(terms) > 1:
            parts.append((1.0, Product(((Sum(tuple(terms)), 1), *denominator))))
        else:
            parts += [(c, Product((*term.factors, *denominator))) for c, term in terms]
    return Sum(tuple(parts))


def _about_one(sums: tuple[tuple[Atom, int], ...]) -> tuple[tuple[tuple[Atom, int], ...], float]:
    """Scale a denominator that is a constant plus waves to 1 + waves; return the constant too.

    So an inertia that varies with an angle can be read. Other denominators stay as they are.
    """
    if len(sums) != 1 or sums[0][1] != -1 or not isinstance(sums[0][0], Sum):
        return sums, 1.0
    constants = [c for c, term in sums[0][0].parts if term == ONE]
    waves = [(c, term) for c, term in sums[0][0].parts if term != ONE]
    if not constants or not all(_is_wave(term) for _, term in waves):
        return sums, 1.0
    scaled = Sum(((1.0, ONE), *((c / constants[0], term) for c, term in waves)))
    return ((scaled, -1),), constants[0]


def _is_wave(term: Product) -> bool:
    (atom, power), *more = term.factors
    is_call = isinstance(atom, Call) and atom.operator.name in ("sin", "cos")
    return is_call and power == 1 and not more
