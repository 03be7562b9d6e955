"""The smaller and the larger of several expressions, written with magnitudes.

A limit reads min(max(u, -1), 1); half of a + b -+ |a - b| is the same, in functions that the rest
of the package knows.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial, reduce

from ..operators import BUILTIN
from ..terms import Sum, add, call, constant, mul, sub

__all__ = ["EXTREMES"]


def _extreme(sign: float, *arguments: Sum) -> Sum:
    def of_two(a: Sum, b: Sum) -> Sum:
        apart = mul(constant(sign), call(BUILTIN["abs"], sub(a, b)))
        return mul(constant(0.5), add(add(a, b), apart))

    return reduce(of_two, arguments)


EXTREMES: dict[str, Callable[..., Sum]] = {
    "min": partial(_extreme, -1.0), "Min": partial(_extreme, -1.0),
    "max": partial(_extreme, 1.0), "Max": partial(_extreme, 1.0),
}  # fmt: skip
