"""Minimum and maximum of expressions, written with magnitudes.

min(a, b) and max(a, b) are (a + b -+ |a - b|)/2, in functions that the rest of the package knows. A
limit such as min(max(u, -1), 1) is (|u + 1| - |u - 1|)/2, with no magnitude inside another.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial, reduce

from ..operators import BUILTIN
from ..terms import ONE, Call, Sum, add, call, constant, mul, neg, sub, value_of


def positive_part_of(expression: Sum) -> Sum | None:
    """Return x of an expression that is max(x, 0); None if it is anything else."""
    x, end = _limited(1.0, expression) or (None, ONE)
    return x if isinstance(end, Sum) and _is_number(end) and value_of(end) == 0.0 else None


def _extreme(sign: float, *arguments: Sum) -> Sum:
    return reduce(partial(_of_two, sign), arguments)


def _of_two(sign: float, a: Sum, b: Sum) -> Sum:
    limited = _limit(sign, a, b) or _limit(sign, b, a)
    return limited or _half(add(a, b), mul(constant(sign), _abs(sub(a, b))))


def _limit(sign: float, inner: Sum, end: Sum) -> Sum | None:
    """Limit x between two numbers, if `inner` is limited on one side and `end` is a number."""
    other = _limited(-sign, inner)
    if other is None or not _is_number(end):
        return None
    x, beginning = other
    if sign * (value_of(end) - value_of(beginning)) > 0.0:  # x is always beyond the outer limit
        return end
    lower, upper = (beginning, end) if sign < 0.0 else (end, beginning)
    return _half(add(lower, upper), sub(_abs(sub(x, lower)), _abs(sub(x, upper))))


def _limited(sign: float, expression: Sum) -> tuple[Sum, Sum] | None:
    """Return x and a number if an expression is their maximum (sign 1) or minimum (sign -1)."""
    for weight, term in expression.parts:
        ((atom, _),) = term.factors if len(term.factors) == 1 else ((None, 0),)
        if weight * sign > 0.0 and isinstance(atom, Call) and atom.operator.name == "abs":
            total = mul(constant(2.0), sub(expression, Sum(((weight, term),))))
            size = mul(constant(2.0 * abs(weight)), atom.args[0])
            for difference in (size, neg(size)):
                x, end = _half(total, difference), _half(total, neg(difference))
                if _is_number(end) and not _is_number(x):
                    return x, end
    return None


def _half(a: Sum, b: Sum) -> Sum:
    return mul(constant(0.5), add(a, b))


def _abs(a: Sum) -> Sum:
    return call(BUILTIN["abs"], a)


def _is_number(a: Sum) -> bool:
    return all(term == ONE for _, term in a.parts)


EXTREMES: dict[str, Callable[..., Sum]] = {
    "min": partial(_extreme, -1.0), "Min": partial(_extreme, -1.0),
    "max": partial(_extreme, 1.0), "Max": partial(_extreme, 1.0),
}  # fmt: skip
