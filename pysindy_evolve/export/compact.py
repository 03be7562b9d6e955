"""Rewrites sums as people write them: powers of differences, fractions and hinges."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import sympy

from ..terms import Sum
from .fractions import as_fractions
from .hinges import as_hinges

__all__ = ["as_written", "compact"]


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
    >>> compact(sympy.exp(-p**2 + 2*p*q - q**2))
    exp(-(p - q)**2)
    """
    expression = sympy.sympify(expression)
    expression = expression.replace(sympy.exp, lambda power: sympy.exp(compact(power)))
    common = sympy.factor_terms(expression)
    if common.is_Mul and any(isinstance(factor, sympy.Abs) for factor in common.args):
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
