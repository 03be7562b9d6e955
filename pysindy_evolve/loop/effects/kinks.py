"""Expressions with a kink or a jump, written with the magnitude and the sign."""

from __future__ import annotations

from ...operators import BUILTIN
from ...terms import Sum, add, call, constant, mul, sub


def magnitude(a: Sum) -> Sum:
    """Return the magnitude of an expression."""
    return call(BUILTIN["abs"], a)


def sign(a: Sum) -> Sum:
    """Return the sign of an expression, zero at zero."""
    return call(BUILTIN["sgn"], a)


def clipped(a: Sum, limit: float) -> Sum:
    """Return a between -limit and limit, written with absolute values."""
    edge = constant(limit)
    return mul(constant(0.5), sub(magnitude(add(a, edge)), magnitude(sub(a, edge))))


def beyond(a: Sum, limit: float) -> Sum:
    """Return how far a lies outside of -limit to limit."""
    return sub(a, clipped(a, limit))
