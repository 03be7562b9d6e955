"""Turns a Python function of arrays into terms, by calling it once on symbols.

``lambda q, v: q * np.abs(v)`` becomes the term q abs(v). A function that cannot be traced
(branches, ``np.where``, special functions), or whose terms give other numbers, is left to the
caller, who wraps it as it is.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from numbers import Real
from typing import Any, NoReturn

import numpy as np

from .. import terms
from ..operators import BUILTIN
from ..terms import Sum, value_of
from .text import real_power

_UFUNCS: dict[np.ufunc, Callable[..., Sum]] = {
    np.add: terms.add,
    np.subtract: terms.sub,
    np.multiply: terms.mul,
    np.divide: terms.div,
    np.negative: terms.neg,
    np.positive: lambda a: a,
    np.reciprocal: lambda a: terms.power(a, -1),
    np.fabs: lambda a: terms.call(BUILTIN["abs"], a),
    np.power: lambda a, b: real_power(a, _exponent(b)),
}
for _name, _ufunc in {
    "square": np.square, "sin": np.sin, "cos": np.cos, "tan": np.tan, "exp": np.exp,
    "log": np.log, "sqrt": np.sqrt, "abs": np.absolute, "sgn": np.sign, "tanh": np.tanh,
    "sinh": np.sinh, "cosh": np.cosh, "asin": np.arcsin, "acos": np.arccos, "atan": np.arctan,
}.items():  # fmt: skip
    _UFUNCS[_ufunc] = lambda a, operator=BUILTIN[_name]: terms.call(operator, a)

# Values of both signs, zero, small and large, at which a function and its terms must agree.
_MAGNITUDES = np.array([0.0, 1e-7, 1e-3, 0.2, 0.7, 1.0, 2.3, 5.0, 11.0, 40.0, 1e3])
_PROBE = np.concatenate([-_MAGNITUDES[:0:-1], _MAGNITUDES])


def trace(function: Callable[..., Any], columns: Sequence[int]) -> Sum | None:
    """Return what a function computes as a sum of terms.

    Parameters
    ----------
    function : callable
        Function of as many arrays as there are `columns`.
    columns : sequence of int
        Variables to call it on.

    Returns
    -------
    Sum or None
        None if the function cannot be traced.
    """
    try:
        result = function(*(_Symbol(terms.variable(index)) for index in columns))
        traced = _as_sum(result)
        if _agree(function, traced, columns):
            return traced
    # The user's function was not written for symbols, so it may fail in any of these ways.
    except (ArithmeticError, AttributeError, LookupError, RuntimeError, TypeError, ValueError):
        pass
    return None


def _agree(function: Callable[..., Any], traced: Sum, columns: Sequence[int]) -> bool:
    rng = np.random.default_rng(0)
    x = np.zeros((3 * len(_PROBE), max(columns, default=0) + 1))
    for index in columns:
        x[:, index] = np.concatenate([_PROBE, rng.permutation(_PROBE), rng.permutation(_PROBE)])
    with np.errstate(all="ignore"):
        expected = np.broadcast_to(function(*(x[:, index] for index in columns)), len(x))
        return np.allclose(
            traced.evaluate(x), expected.astype(float), rtol=1e-9, atol=1e-12, equal_nan=True
        )


class _Symbol(np.lib.mixins.NDArrayOperatorsMixin):
    """A symbol in place of an array in a call of the user's function; records the operations."""

    def __init__(self, value: Sum) -> None:
        self.value = value

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **options: Any) -> Any:
        if method != "__call__" or options or ufunc not in _UFUNCS:
            return NotImplemented
        return _Symbol(_UFUNCS[ufunc](*(_as_sum(value) for value in inputs)))

    def __array_function__(self, *_: Any) -> Any:
        return NotImplemented

    def __array__(self, *_: Any, **__: Any) -> NoReturn:
        raise TypeError("a symbol is no array")

    def __bool__(self) -> NoReturn:
        raise TypeError("a symbol has no truth value")


def _as_sum(value: Any) -> Sum:
    if isinstance(value, _Symbol):
        return value.value
    if isinstance(value, Real) and math.isfinite(value):
        return terms.constant(float(value))
    raise TypeError(f"neither a symbol nor a number: {type(value).__name__}")


def _exponent(exponent: Sum) -> float:
    if exponent.variables:
        raise TypeError("an exponent that varies")
    value = value_of(exponent)
    if abs(value) > 64:
        raise ValueError("an exponent too large to multiply out")
    return value
