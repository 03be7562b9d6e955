"""Operators applied to sums: arithmetic is carried out, signs are pulled out."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from ..operators import BUILTIN, Operator
from .arithmetic import add, as_atom, constant, div, mul, neg, power, sub
from .atoms import Call
from .products import ONE
from .sums import Atom, Sum, as_sum, of_term

_ODD = ("sin", "tan", "tanh", "sinh", "asin", "atan", "softsign")
_EVEN = ("cos", "cosh")
_ARITHMETIC: dict[str, Callable[..., Sum]] = {
    "add": add,
    "sub": sub,
    "mul": mul,
    "div": div,
    "neg": neg,
    "square": lambda a: power(a, 2),
    "cube": lambda a: power(a, 3),
}


def call(operator: Operator, *args: Sum) -> Sum:
    """Return operator(*args) in canonical form; arithmetic operators are carried out.

    Parameters
    ----------
    operator : Operator
        A built-in operator or a user's own.
    *args : Sum
        As many as the arity of the operator.

    Returns
    -------
    Sum
    """
    if BUILTIN.get(operator.name) != operator:
        return as_sum(Call(operator, args))
    if operator.name in _ARITHMETIC:
        return _ARITHMETIC[operator.name](*args)
    (argument,) = args
    if not argument.variables:
        return _of_constant(operator, argument)
    if operator.name in ("abs", "sgn"):
        return _magnitude_or_sign(operator, argument)
    if operator.name == "exp":
        return _exponential(argument)
    if operator.name == "sqrt":
        return _root(argument)
    if operator.name in _ODD and argument.parts[0][0] < 0:
        return neg(as_sum(Call(operator, (neg(argument),))))
    if operator.name in _EVEN and argument.parts[0][0] < 0:
        argument = neg(argument)
    return as_sum(Call(operator, (argument,)))


def _of_constant(operator: Operator, argument: Sum) -> Sum:
    with np.errstate(all="ignore"):
        value = float(operator(argument.evaluate(np.empty((1, 0))))[0])
    return constant(value) if math.isfinite(value) else as_sum(Call(operator, (argument,)))


def _exponential(argument: Sum) -> Sum:
    """Take the constant out: exp(0.5 + x) = exp(0.5) exp(x)."""
    offset = [part for part in argument.parts if part[1] == ONE]
    rest = Sum(tuple(part for part in argument.parts if part[1] != ONE))
    with np.errstate(all="ignore"):
        factor = float(np.exp(sum(c for c, _ in offset)))
    if not offset or not 0.0 < factor < math.inf:
        return as_sum(Call(BUILTIN["exp"], (argument,)))
    return mul(constant(factor), as_sum(Call(BUILTIN["exp"], (rest,))))


def _root(argument: Sum) -> Sum:
    """Take a factor out: sqrt(4 x) = 2 sqrt(x)."""
    (coefficient, term), *others = argument.parts
    if others or coefficient <= 0.0:
        return as_sum(Call(BUILTIN["sqrt"], (argument,)))
    root = as_sum(Call(BUILTIN["sqrt"], (of_term(term),)))
    return mul(constant(math.sqrt(coefficient)), root)


def _magnitude_or_sign(operator: Operator, argument: Sum) -> Sum:
    """Apply abs or sgn factor by factor: abs(2 q v) = 2 abs(q) abs(v)."""
    ((coefficient, term),) = as_atom(argument).parts
    sign = operator.name == "sgn"
    result = constant(math.copysign(1.0, coefficient) if sign else abs(coefficient))
    for atom, exponent in term.factors:
        for _ in range(abs(exponent)):
            factor = _magnitude_or_sign_of_atom(operator, atom)
            # 1/sgn would differ from sgn at zero only, where 1/x has no value anyway.
            result = mul(result, factor) if exponent > 0 else div(result, factor)
    return result


def _magnitude_or_sign_of_atom(operator: Operator, atom: Atom) -> Sum:
    itself = as_sum(atom)
    if isinstance(atom, Call) and atom.operator == BUILTIN["sgn"]:
        return itself if operator.name == "sgn" else mul(itself, itself)
    if isinstance(atom, Call) and atom.operator == BUILTIN["abs"]:
        inner = as_sum(Call(BUILTIN["sgn"], atom.args))
        return itself if operator.name == "abs" else mul(inner, inner)
    return as_sum(Call(operator, (atom if isinstance(atom, Sum) else itself,)))
