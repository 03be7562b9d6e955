"""Sums as people write them: powers of differences, and what is beyond an end."""

from __future__ import annotations

from typing import Any

import sympy

__all__ = ["compact"]

ROUNDING = 1e-12  # of what should cancel


def compact(expression: Any) -> Any:
    """Return a sum as a power of a shorter one, or half of |a| + a as max(a, 0), where it is that.

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
    >>> compact(0.5*p + 0.5*abs(p - 3) - 1.5)
    Max(0, p - 3)
    >>> compact(p*abs(p - q) - q*abs(p - q))
    (p - q)*Abs(p - q)
    """
    expression = sympy.sympify(expression)
    beyond = _beyond(expression)
    if beyond is not None:
        return beyond
    common = sympy.factor_terms(expression)
    if common.is_Mul and any(isinstance(factor, sympy.Abs) for factor in common.args):
        return common
    if not expression.is_Add or len(expression.args) < 3 or not expression.is_polynomial():
        return expression
    factored = sympy.factor(sympy.nsimplify(expression, rational=True))
    factor, power = factored.as_coeff_Mul()
    if not power.is_Pow:
        return expression
    if factor == -1 and power.exp.is_odd:  # a coefficient before it has a sign of its own
        return sympy.Pow(sympy.expand(-power.base), power.exp)
    return factored


def _beyond(expression: Any) -> Any:
    """Return c |a| + c a as 2 c max(a, 0); None if it is anything else."""
    magnitudes = expression.atoms(sympy.Abs)
    weight = expression.coeff(next(iter(magnitudes))) if len(magnitudes) == 1 else None
    if weight is None or not weight.is_number:
        return None
    (magnitude,) = magnitudes
    for inside in (magnitude.args[0], -magnitude.args[0]):
        left = sympy.expand(expression - weight * (magnitude + inside))
        if all(abs(number) < ROUNDING for number in left.as_coefficients_dict().values()):
            factor = 2 * weight
            return (1 if abs(factor - 1) < ROUNDING else factor) * sympy.Max(inside, 0)
    return None
