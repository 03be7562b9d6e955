"""Equations as plain text: ``v' = -691.9 q - 1.1 v - 2.37e6 q^3 - 2.93 sgn(v)``."""

from __future__ import annotations

import re
from typing import Any

import sympy
from sympy.printing.str import StrPrinter

from ..terms import Sum, join_terms
from .symbolic import System, as_shown, system_of


def format_equations(model: Any, digits: int | None = 4) -> str:
    """Return the equations as text, one line for each state.

    Parameters
    ----------
    model : pysindy.SINDy, Equations or LoopReport
        Fitted model, or an object that holds one.
    digits : int or None
        Significant digits of all numbers; None for as many as they have.

    Returns
    -------
    str

    Examples
    --------
    >>> import numpy as np
    >>> from pysindy_evolve.equations import Equations
    >>> from pysindy_evolve.terms import only_term, variable
    >>> term = only_term(variable(0))
    >>> print(format_equations(Equations((term,), np.array([[-2.18e6]]), ("q",))))
    q' = -2.18e6 q
    """
    system = system_of(model, "format_equations", digits)
    lines = zip(system.lefts, system.are_rates, system.sides, strict=True)
    return "\n".join(
        _plain(left) + ("'" if is_rate else "") + f" = {_side(system, side, digits)}"
        for left, is_rate, side in lines
    )


def format_expression(expression: Any, digits: int | None = 4) -> str:
    """Return a sympy expression as text, in the style of `format_equations`.

    Parameters
    ----------
    expression : sympy.Expr
        The expression.
    digits : int or None
        Significant digits of all numbers; None for as many as they have.

    Returns
    -------
    str

    Examples
    --------
    >>> q, v = sympy.symbols("q v", real=True)
    >>> format_expression(-7631.2 * q**2 * sympy.sign(v) + sympy.Abs(v) / 3)
    '-7631 q^2 sgn(v) + |v|/3'
    >>> format_expression((q - 2) ** -2)
    '1/(q - 2)^2'
    >>> format_expression(1.00001 * q * (v - q))  # four digits do not tell 1.00001 from 1
    'q (v - q)'
    """
    return TextPrinter(digits).doprint(expression)


def format_number(value: float, digits: int | None = 4) -> str:
    """Return a number with significant digits, large and small ones as 2.18e6 and 1.5e-5.

    Parameters
    ----------
    value : float
        The number.
    digits : int or None
        Significant digits; None for as many as it has.

    Returns
    -------
    str

    Examples
    --------
    >>> format_number(2180123.0), format_number(1.5e-5), format_number(-3.0)
    ('2.18e6', '1.5e-5', '-3')
    """
    text = repr(float(value)) if digits is None else f"{value:.{digits}g}"
    mantissa, _, exponent = text.removesuffix(".0").partition("e")
    return f"{mantissa.removesuffix('.0')}e{int(exponent)}" if exponent else mantissa


class TextPrinter(StrPrinter):
    """Prints sympy expressions with sgn, |v|, ^ for powers and a space for products.

    Parameters
    ----------
    digits : int or None
        Significant digits of all numbers.
    """

    def __init__(self, digits: int | None = 4) -> None:
        super().__init__()
        self.digits = digits

    def _print_Float(self, expression: Any) -> str:
        return format_number(float(expression), self.digits)

    def _print_Integer(self, expression: Any) -> str:
        large = abs(expression) >= 10**6
        return format_number(int(expression), self.digits) if large else str(int(expression))

    def _print_Symbol(self, expression: Any) -> str:
        return _plain(expression.name)

    def _print_sign(self, expression: Any) -> str:
        return f"sgn({self._print(expression.args[0])})"

    def _print_Abs(self, expression: Any) -> str:
        return f"|{self._print(expression.args[0])}|"

    def _print_Min(self, expression: Any) -> str:
        last = sorted(expression.args, key=lambda argument: bool(argument.is_number))
        return f"{type(expression).__name__.lower()}({', '.join(map(self._print, last))})"

    _print_Max = _print_Min

    def _as_ordered_terms(self, expression: Any, order: Any = None) -> list[Any]:
        """Return the terms of a sum: b - a, not -a + b; a whole line begins as it is ordered."""
        terms = list(super()._as_ordered_terms(expression, order))
        leads = terms[0].as_coeff_Mul()[0]
        if leads > 0 or (self._print_level == 1 and leads != -1):
            return terms
        first = next((term for term in terms if not term.could_extract_minus_sign()), terms[0])
        return [first, *(term for term in terms if term is not first)]

    def _print_Mul(self, expression: Any) -> str:
        number, rest = expression.as_coeff_Mul()
        if number.is_Float and self._print(abs(number)) == "1":  # q, not 1 q
            expression = rest if number > 0 else -rest
        if not expression.is_Mul:
            return str(self._print(expression))
        return str(super()._print_Mul(expression)).replace("*", " ")

    def _print_Pow(self, expression: Any, rational: bool = False) -> str:
        if expression.exp.is_Integer and expression.exp < -1:
            return f"1/{self._print(1 / expression)}"
        return str(super()._print_Pow(expression, rational)).replace("**", "^")


def _side(system: System, side: Sum, digits: int | None) -> str:
    printer = TextPrinter(digits)

    def term(expression: Any) -> str:
        text = "" if expression == 1 else printer.doprint(expression)
        return f"({text})" if isinstance(expression, sympy.Add) else text

    parts = as_shown(side, system.equations.symbols)
    return join_terms(parts, lambda value: format_number(value, digits), term)


def _plain(name: str) -> str:
    """Return a name, in parentheses if it is not a single word."""
    return name if re.fullmatch(r"\w+", name) else f"({name})"
