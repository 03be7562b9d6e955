"""Equations as MathML, which browsers display without scripts or network."""

from __future__ import annotations

import re
from typing import Any

import sympy
from sympy.core.function import AppliedUndef
from sympy.printing.mathml import MathMLPresentationPrinter

from ..terms import signed
from .printing import format_number
from .symbolic import as_shown, system_of

# Room that does not depend on the font: many browsers have none for mathematics.
TIMES = '<mo lspace="0.08em" rspace="0.08em">\u2062</mo>'
CHARACTERS = {"&ExponentialE;": "e", "<mo>&InvisibleTimes;</mo>": TIMES, "<mo>-</mo>": "<mo>−</mo>"}


def equations_mathml(model: Any, digits: int = 4) -> list[list[str]]:
    """Return each equation in pieces; a line may break between two of them.

    Parameters
    ----------
    model : pysindy.SINDy, Equations or LoopReport
        Fitted model, or an object that holds one.
    digits : int
        Significant digits of all numbers.

    Returns
    -------
    list of list of str
        For each state the left-hand side with its equal sign, then each term with its sign; every
        piece is a ``<math>`` element.
    """
    system = system_of(model, "equations_mathml", digits)
    symbols, printer = system.equations.symbols, _Printer(digits)
    lines = []
    for left, is_rate, side in zip(system.lefts, system.are_rates, system.sides, strict=True):
        name = printer.doprint(sympy.Symbol(left))
        shown = _dotted(name) if is_rate else name
        terms = signed(as_shown(side, symbols))
        pieces = [
            _math(_between(sign, bool(place)) + _scaled(size, term, printer))
            for place, (sign, size, term) in enumerate(terms)
        ]
        lines.append([_math(f"{shown}<mo>=</mo>"), *(pieces or [_math("<mn>0</mn>")])])
    return lines


def expression_mathml(expression: Any, digits: int = 4) -> str:
    """Return a sympy expression as a ``<math>`` element.

    Parameters
    ----------
    expression : sympy.Expr
        The expression.
    digits : int
        Significant digits of all numbers.

    Returns
    -------
    str
    """
    return _math(_Printer(digits).doprint(expression))


def _dotted(name: str) -> str:
    """Return a name with a dot above its letter, and not above its index."""
    return re.sub(r"(<mi>.*?</mi>)", r"<mover>\1<mo>˙</mo></mover>", name, count=1)


def _between(sign: str, has_left: bool) -> str:
    """Return a sign, with room on both sides if it has a term to its left."""
    space = ' lspace="0" rspace="0.25em"' if has_left else ' form="prefix"'
    return f"<mo{space}>{sign.replace('-', '−')}</mo>" if sign else ""


def _scaled(size: float, expression: Any, printer: _Printer) -> str:
    """Return a term with its coefficient, which is left out if it is 1."""
    number = format_number(size, printer.digits)
    if expression == 1:
        return _number(number)
    term = printer.doprint(expression)
    if isinstance(expression, sympy.Add):
        term = f"<mrow><mo>(</mo>{term}<mo>)</mo></mrow>"
    return term if number == "1" else f'{_number(number)}<mspace width="0.15em"/>{term}'


def _math(body: str) -> str:
    return f"<math>{body}</math>"


def _number(text: str) -> str:
    """Return a printed number, with its power of ten raised."""
    mantissa, _, exponent = text.partition("e")
    if not exponent:
        return f"<mn>{mantissa.replace('-', '−')}</mn>"
    power = f"<msup><mn>10</mn><mn>{exponent.replace('-', '−')}</mn></msup>"
    return power if mantissa == "1" else f"<mn>{mantissa}</mn><mo>·</mo>{power}"


class _Printer(MathMLPresentationPrinter):
    def __init__(self, digits: int) -> None:
        super().__init__()
        self.digits = digits

    def doprint(self, expression: Any) -> str:
        """Return the expression, with characters instead of sympy's entities."""
        text = str(super().doprint(expression))
        for entity, sign in CHARACTERS.items():
            text = text.replace(entity, sign)
        return text

    def _print_Float(self, expression: Any) -> Any:
        row = self.dom.createElement("mrow")
        mantissa, _, exponent = format_number(float(expression), self.digits).partition("e")
        row.appendChild(self._text("mn", mantissa))
        if exponent:
            power = self.dom.createElement("msup")
            power.appendChild(self._text("mn", "10"))
            power.appendChild(self._text("mn", exponent))
            row.appendChild(self._text("mo", "·"))
            row.appendChild(power)
        return row

    def _print_sign(self, expression: Any) -> Any:
        row = self.dom.createElement("mrow")
        row.appendChild(self._text("mi", "sgn"))
        inside = self.dom.createElement("mrow")
        for child in (self._text("mo", "("), self._print(expression.args[0])):
            inside.appendChild(child)
        inside.appendChild(self._text("mo", ")"))
        row.appendChild(inside)
        return row

    def _print_Mul(self, expression: Any) -> Any:
        """Print an exponential as a factor; sympy would divide by its inverse."""
        if not any(isinstance(factor, sympy.exp) for factor in expression.args):
            return super()._print_Mul(expression)
        row = self.dom.createElement("mrow")
        factors = sorted(expression.args, key=lambda factor: isinstance(factor, sympy.exp))
        for place, factor in enumerate(factors):
            if place:
                times = self.dom.createElement("mo")
                times.appendChild(self.dom.createTextNode("&InvisibleTimes;"))
                row.appendChild(times)
            row.appendChild(self._print(factor))
        return row

    def _print_exp(self, expression: Any) -> Any:
        row = self.dom.createElement("mrow")
        for child in (self._text("mi", "exp"), self._text("mo", "(")):
            row.appendChild(child)
        row.appendChild(self._print(expression.args[0]))
        row.appendChild(self._text("mo", ")"))
        return row

    def _print_Function(self, expression: Any) -> Any:
        """Keep the case of an undefined function, as in a delayed input F(t - 0.1), not f."""
        row = super()._print_Function(expression)
        if isinstance(expression, AppliedUndef) and row.firstChild is not None:
            row.replaceChild(self._text("mi", expression.func.__name__), row.firstChild)
        return row

    def _text(self, tag: str, text: str) -> Any:
        element = self.dom.createElement(tag)
        element.appendChild(self.dom.createTextNode(text.replace("-", "−")))
        return element
