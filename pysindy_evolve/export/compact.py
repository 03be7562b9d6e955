"""Rewrites sums as people write them: powers of differences, fractions and hinges."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import sympy

from ..terms import ONE, Atom, Call, Product, Sum
from .hinges import as_hinges


def as_written(expression: Sum, symbols: Sequence[Any]) -> Any:
    """Return an expression in sympy as people write it: fractions, hinges, powers of differences.

    Parameters
    ----------
    expression : Sum
        Multiplied out.
    symbols : sequence of sympy.Symbol
        The variables.

    Returns
    -------
    sympy expression
    """
    return compact(as_fractions(as_hinges(expression)).to_sympy(symbols))


def compact(expression: Any) -> Any:
    """Return a sum as a power of a shorter one, or with a common magnitude as factor, if possible.

    Parameters
    ----------
    expression : sympy expression

    Returns
    -------
    sympy expression
        Equal to the one given.

    Examples
    --------
    >>> from sympy.abc import p, q
    >>> compact(p**2 - 2*p*q + q**2)
    (p - q)**2
    >>> compact(p**3 - 3*p**2*q + 3*p*q**2 - q**3)
    (p - q)**3
    >>> compact(p**2 + 0.6*p + 0.09)
    (p + 0.3)**2
    >>> compact(p**2 + q)
    p**2 + q
    >>> compact(p*abs(p - q) - q*abs(p - q))
    (p - q)*Abs(p - q)
    >>> compact(p*sympy.sqrt(abs(p - q)) - q*sympy.sqrt(abs(p - q)))
    (p - q)*sqrt(Abs(p - q))
    >>> compact(sympy.exp(-p**2 + 2*p*q - q**2))
    exp(-(p - q)**2)
    """
    expression = sympy.sympify(expression)
    expression = expression.replace(sympy.exp, lambda power: sympy.exp(compact(power)))
    common = sympy.factor_terms(expression)
    if common.is_Mul and any(
        isinstance(factor.as_base_exp()[0], sympy.Abs | sympy.Max) for factor in common.args
    ):
        return common
    if not expression.is_Add or len(expression.args) < 3 or not expression.is_polynomial():
        return expression
    factored = sympy.factor(sympy.nsimplify(expression, rational=True))
    factor, power = factored.as_coeff_Mul()
    if not power.is_Pow:
        return expression
    base, exponent = power.args
    lead = sympy.Poly(base).LC()
    factor, base = factor * lead**exponent, sympy.expand(base / lead)
    if factor == -1 and exponent.is_odd:  # else two signs may stand in a row
        factor, base = 1, sympy.expand(-base)
    return _as_decimals(factor) * sympy.Pow(_as_decimals(base), exponent)


def _as_decimals(expression: Any) -> Any:
    fractions = (n for n in sympy.sympify(expression).atoms(sympy.Rational) if n.q > 1)
    return sympy.sympify(expression).xreplace({n: sympy.Float(n) for n in fractions})


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
