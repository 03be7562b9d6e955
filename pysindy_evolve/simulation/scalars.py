"""Scalar functions compiled from sympy expressions, with numbers and user functions by name."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import sympy

from ..operators import Operator

Lines = list[tuple[Any, Any]]  # assignments (symbol, expression), in order

RATIO = sympy.Function("ratio", real=True)
ROOT = sympy.Function("root", real=True)
LEAST = sympy.Function("least", real=True)
LOG = sympy.Function("logarithm", real=True)


def symbol(name: str) -> Any:
    """Return a real symbol."""
    return sympy.Symbol(name, real=True)


def symbols(name: str, n: int) -> list[Any]:
    """Return n real symbols."""
    return [symbol(f"{name}{i}") for i in range(n)]


class Namespace:
    """Numbers and functions that the compiled programs of one structure use by name.

    sympy.lambdify takes the whole program as its list of common subexpressions, so that no code
    is put together from text here. Numbers enter as symbols: printed floats would lose digits.
    """

    def __init__(self) -> None:
        self._values: dict[str, Any] = {
            "ratio": ratio, "least": min, "root": math.sqrt, "logarithm": logarithm
        }  # fmt: skip
        self._numbers: dict[float, Any] = {}

    def number(self, value: float) -> Any:
        """Return a symbol that holds a number."""
        if value not in self._numbers:
            name = f"n{len(self._numbers)}"
            self._numbers[value] = symbol(name)
            self._values[name] = value
        return self._numbers[value]

    def function(self, operator: Operator) -> Any:
        """Return the user's own numpy function: what is scored is what is simulated."""
        name = f"user_{operator.name}"
        self._values[name] = on_floats(operator)
        return sympy.Function(name, real=True)

    def compiled(self, arguments: list[Any], lines: Lines, result: Any) -> Callable[..., Any]:
        """Compile a function of some arguments: its lines, then its result."""
        return sympy.lambdify(
            arguments,
            result,
            modules=[dict(self._values), "math"],
            cse=lambda expressions: (lines, expressions),
        )


def ratio(a: float, b: float) -> float:
    """Return -a/b, the sign sigma at which a + b*sigma is zero; 0 if both are zero."""
    if b:
        return -a / b
    return math.copysign(math.inf, a) if a else 0.0


def logarithm(a: float) -> float:
    """Return log(a), as numpy does at zero: a power of a magnitude is exp(n log(abs(a)))."""
    return math.log(a) if a else -math.inf


def on_floats(operator: Operator) -> Callable[..., float]:
    """Wrap a function of arrays as a function of floats."""

    def wrapped(*arguments: float) -> float:
        with np.errstate(all="ignore"):
            return float(np.asarray(operator(*(np.array([a]) for a in arguments)))[0])

    return wrapped
