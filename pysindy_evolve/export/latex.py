r"""Equations as LaTeX, such as ``\dot{v} = - 2.37 \cdot 10^{6} q^{3}``."""

from __future__ import annotations

import re
from typing import Any

import sympy
from sympy.printing.latex import LatexPrinter

from ..terms import join_terms
from .printing import format_number
from .symbolic import as_shown, system_of


def to_latex(model: Any, digits: int | None = 4) -> str:
    r"""Return the equations as LaTeX for math mode.

    Parameters
    ----------
    model : pysindy.SINDy, Equations or LoopReport
        Fitted model, or an object that holds one.
    digits : int or None
        Significant digits of all numbers; None for as many as they have.

    Returns
    -------
    str
        One equation, or several in an ``aligned`` environment.

    Raises
    ------
    TypeError
        If `model` is no model, or its library is one of partial derivatives or weak forms.
    sklearn.exceptions.NotFittedError
        If `model` has not been fitted.
    ValueError
        If two variables share a name, or `digits` is below 1.

    Examples
    --------
    >>> import numpy as np
    >>> from pysindy_evolve.equations import Equations
    >>> from pysindy_evolve.terms import only_term, variable
    >>> term = only_term(variable(0))
    >>> print(to_latex(Equations((term,), np.array([[-2.18e6]]), ("q",))))
    \dot{q} = -2.18 \cdot 10^{6} q
    """
    system = system_of(model, "to_latex", digits)
    printer = _Printer(digits)

    def term(expression: Any) -> str:
        text = "" if expression == 1 else printer.doprint(expression)
        return rf"\left({text}\right)" if isinstance(expression, sympy.Add) else text

    lines = []
    for left, is_rate, side in zip(system.lefts, system.are_rates, system.sides, strict=True):
        name = printer.doprint(sympy.Symbol(left))
        dotted = rf"\dot{{{name}}}" if is_rate else name
        parts = as_shown(side, system.equations.symbols)
        right = join_terms(parts, lambda value: _number(value, digits), term)
        lines.append((dotted, right))
    if len(lines) == 1:
        return " = ".join(lines[0])
    body = " \\\\\n".join(f"{dotted} &= {right}" for dotted, right in lines)
    return f"\\begin{{aligned}}\n{body}\n\\end{{aligned}}"


class _Printer(LatexPrinter):
    def __init__(self, digits: int | None) -> None:
        super().__init__()
        self.digits = digits

    def _print_Float(self, expression: Any) -> str:
        return _number(float(expression), self.digits)

    def _print_Symbol(self, expression: Any, style: str = "plain") -> str:
        if re.fullmatch(r"\w+", expression.name, re.ASCII):
            text = str(super()._print_Symbol(expression, style))
            is_word = len(text) > 1 and text.isalnum()  # else it reads as a product of letters
            return rf"\mathrm{{{text}}}" if is_word else text
        return rf"\text{{{_escaped(expression.name)}}}"

    def _print_sign(self, expression: Any, exp: Any = None) -> str:
        power = "" if exp is None else f"^{{{exp}}}"
        argument = self._print(expression.args[0])
        return rf"\operatorname{{sgn}}{power}\left({argument}\right)"


def _number(value: float, digits: int | None) -> str:
    mantissa, _, exponent = format_number(value, digits).partition("e")
    if not exponent:
        return mantissa
    power = f"10^{{{exponent}}}"
    return power if mantissa == "1" else rf"{mantissa} \cdot {power}"


def _escaped(name: str) -> str:
    named = {"\\": r"\textbackslash{}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}"}
    return re.sub(r"[\\~^&%$#_{}]", lambda m: named.get(m.group(), "\\" + m.group()), name)
