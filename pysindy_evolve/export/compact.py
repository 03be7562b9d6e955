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
    >>> compact(p**2 + q)
    p**2 + q
    """
    expression = sympy.sympify(expression)
    if not expression.is_Add or len(expression.args) < 3 or not expression.is_polynomial():
        return expression
    factored = sympy.factor(sympy.nsimplify(expression, rational=True))
    return factored if factored.as_coeff_Mul()[1].is_Pow else expression
