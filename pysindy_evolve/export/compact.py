"""Sums as people write them: a force between two bodies is a power of a difference."""

from __future__ import annotations

from typing import Any

import sympy

__all__ = ["compact"]


def compact(expression: Any) -> Any:
    """Return a sum that is a power of a shorter sum as that power, anything else as it is.

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
    >>> compact(p**2 + q)
    p**2 + q
    """
    expression = sympy.sympify(expression)
    if not expression.is_Add or len(expression.args) < 3 or not expression.is_polynomial():
        return expression
    factored = sympy.factor(sympy.nsimplify(expression, rational=True))
    factor, power = factored.as_coeff_Mul()
    if not power.is_Pow:
        return expression
    if factor == -1 and power.exp.is_odd:  # a coefficient before it has a sign of its own
        return sympy.Pow(sympy.expand(-power.base), power.exp)
    return factored
