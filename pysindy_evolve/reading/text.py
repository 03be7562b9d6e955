"""Right-hand sides as text or sympy: read against a whitelist, never executed.

The result is linear in its free parameters: ``-k*q - c*v + 3`` means k times ``-q``, c times
``-v``, and a known part ``3``.
"""

from __future__ import annotations

import ast
import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .. import terms
from ..operators import BUILTIN, Operator
from ..terms import Sum, value_of
from .extremes import EXTREMES, positive_part_of
from .grammar import MAX_EXPONENT, MAX_SIZE, Source, as_text, chain
from .names import advise_function, advise_parameter, check_known

# Arithmetic is written with its signs; Abs and sign are what sympy prints, arctan what numpy says.
FUNCTIONS: dict[str, Operator] = {
    name: operator
    for name, operator in BUILTIN.items()
    if name not in ("add", "sub", "mul", "div", "neg")
} | {
    "Abs": BUILTIN["abs"], "sign": BUILTIN["sgn"], "ln": BUILTIN["log"],
    "arcsin": BUILTIN["asin"], "arccos": BUILTIN["acos"], "arctan": BUILTIN["atan"],
}  # fmt: skip


@dataclass(frozen=True)
class RightHandSide:
    """A right-hand side that is linear in its free parameters.

    Attributes
    ----------
    known : Sum
        The part without free parameters, in units of x_dot.
    free : tuple of (str, Sum)
        Free parameters in the order of the text, each with the expression that it multiplies.
    names : frozenset of str
        All names in the text.
    """

    known: Sum
    free: tuple[tuple[str, Sum], ...]
    names: frozenset[str] = field(default=frozenset(), compare=False)

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of the free parameters."""
        return tuple(name for name, _ in self.free)


def parse(
    text: Any,
    variables: Mapping[str, int] | Sequence[str],
    *,
    known: Mapping[str, float] | None = None,
    operators: Iterable[Operator] = (),
    inputs: Collection[str] = (),
    owner: str = "parse(text=...)",
) -> RightHandSide:
    """Read one right-hand side.

    Names that are neither variables nor in `known` are free parameters, which must enter linearly.

    Parameters
    ----------
    text : str, sympy.Expr or float
        The right-hand side: numbers, ``pi``, names, ``+ - * /``, ``**`` or ``^``, and calls of
        `FUNCTIONS`, of ``min`` and ``max``, or of `operators`.
    variables : mapping of str to int, or sequence of str
        Name and column of each variable; a sequence numbers them from 0.
    known : mapping of str to float, optional
        Constants with a value.
    operators : iterable of Operator
        Functions of the user, next to the built-in ones.
    inputs : collection of str
        Names of the inputs among the variables, for error messages.
    owner : str
        The call and parameter to name in an error.

    Returns
    -------
    RightHandSide

    Raises
    ------
    ValueError
        If the text is no expression of the whitelist, is nonlinear in a free parameter, or is too
        long or too deep.
    TypeError
        If `text` is neither text, a sympy expression nor a number.

    Examples
    --------
    >>> side = parse("-k*q - c*v + 3*sgn(v)", ["q", "v"])
    >>> side.parameters
    ('k', 'c')
    >>> side.known.name(["q", "v"])
    '3 sgn(v)'
    """
    source = Source(as_text(text, owner), owner)
    columns = {name: index for index, name in enumerate(variables)}
    if isinstance(variables, Mapping):
        columns = dict(variables)
    functions = FUNCTIONS | {operator.name: operator for operator in operators}
    constants = check_known(known or {}, "parse")
    value = _Reader(source, columns, constants, functions, inputs).value(source.tree)
    free = sorted(_parameters(value), key=source.names.index)
    parts = tuple((name, value[name]) for name in free)
    return RightHandSide(value.get(None, Sum(())), parts, frozenset(source.names))


# The factor of each free parameter; None is the key of the part without any.
_Linear = dict[str | None, Sum]


@dataclass(frozen=True)
class _Reader:
    """Turns a syntax tree into terms."""

    source: Source
    columns: Mapping[str, int]
    known: Mapping[str, float]
    functions: Mapping[str, Operator]
    inputs: Collection[str] = ()

    def value(self, node: ast.expr) -> _Linear:
        try:
            value = self._operation(node)
        except (OverflowError, ZeroDivisionError):
            self.source.fail_number(node)
        if not all(math.isfinite(c) for part in value.values() for c in part.constants):
            self.source.fail_number(node)
        if sum(part.size for part in value.values()) > MAX_SIZE:
            self.source.fail_size(node)
        return {name: part for name, part in value.items() if part.parts}

    def _operation(self, node: ast.expr) -> _Linear:
        match node:
            case ast.Constant():
                return {None: terms.constant(float(node.value))}  # type: ignore[arg-type]
            case ast.Name():
                return self._name(node)
            case ast.UnaryOp(op=ast.USub()):
                return {k: terms.neg(part) for k, part in self.value(node.operand).items()}
            case ast.UnaryOp():
                return self.value(node.operand)
            case ast.BinOp(op=ast.Pow()):
                return {None: self._power(node)}
            case ast.BinOp(op=ast.Add() | ast.Sub()):
                return self._sum(node)
            case ast.BinOp():
                return self._product(node)
            case ast.Call():
                return {None: self._call(node)}
        return self.source.fail_syntax(node)

    def _name(self, node: ast.Name) -> _Linear:
        name = self.source.name(node)
        if name in self.columns:
            return {None: terms.variable(self.columns[name])}
        if name in self.known:
            return {None: terms.constant(float(self.known[name]))}
        if name == "pi":
            return {None: terms.constant(math.pi)}
        if name in self.functions:
            advice = f"Write {name}(...), or rename the parameter."
            self.source.fail("must call its functions", repr(name), advice, node)
        if name.startswith("__"):
            advice = "Rename it without the leading underscores."
            self.source.fail("must use plain names", repr(name), advice, node)
        return {name: terms.constant(1.0)}

    def _sum(self, node: ast.BinOp) -> _Linear:
        parts: dict[str | None, list[Sum]] = {}
        for operation, operand in chain(node):
            for name, part in self.value(operand).items():
                signed = terms.neg(part) if isinstance(operation, ast.Sub) else part
                parts.setdefault(name, []).append(signed)
        return {name: _total(sums) for name, sums in parts.items()}

    def _product(self, node: ast.BinOp) -> _Linear:
        (_, first), *rest = chain(node)
        result = self.value(first)
        for operation, operand in rest:
            factor = self.value(operand)
            if isinstance(operation, ast.Div):
                result = self._divided(result, factor, operand)
            else:
                result = self._multiplied(result, factor, operand)
            if sum(part.size for part in result.values()) > MAX_SIZE:
                self.source.fail_size(operand)
        return result

    def _multiplied(self, a: _Linear, b: _Linear, node: ast.expr) -> _Linear:
        in_a, in_b = _parameters(a), _parameters(b)
        if in_a and in_b:
            what = f"the product of {in_a[0]!r} and {in_b[0]!r}"
            self._fail_nonlinear(what, [in_b[0], in_a[0]], node)
        if in_b:
            a, b = b, a
        factor = b.get(None, Sum(()))
        return {name: terms.mul(part, factor) for name, part in a.items()}

    def _divided(self, a: _Linear, b: _Linear, node: ast.expr) -> _Linear:
        if parameters := _parameters(b):
            self._fail_nonlinear(f"a division by {parameters[0]!r}", parameters[:1], node)
        if not b:
            self.source.fail_number(node)
        return {name: terms.div(part, b[None]) for name, part in a.items()}

    def _power(self, node: ast.BinOp) -> Sum:
        base, exponent = self._parameter_free(node.left), self._parameter_free(node.right)
        if exponent.variables:
            if base.variables or value_of(base) <= 0.0:
                advice = "Write it with exp and log."
                self.source.fail(
                    "must have constant exponents", "one that varies", advice, node.right
                )
            log = terms.constant(math.log(value_of(base)))
            return terms.call(BUILTIN["exp"], terms.mul(exponent, log))
        if not base.variables:
            value = value_of(base) ** value_of(exponent)
            return terms.constant(math.nan if isinstance(value, complex) else value)
        if abs(value_of(exponent)) * max(base.size, MAX_SIZE / MAX_EXPONENT) > MAX_SIZE:
            self.source.fail_size(node.right)
        result = real_power(base, value_of(exponent))
        if any(abs(n) > MAX_EXPONENT for _, term in result.parts for _, n in term.factors):
            self.source.fail_size(node.right)  # a power of powers
        return result

    def _call(self, node: ast.Call) -> Sum:
        if not isinstance(node.func, ast.Name) or node.keywords:
            self.source.fail_syntax(node)
        name = self.source.name(node.func)
        operator = self.functions.get(name)
        if operator is None and name in EXTREMES and node.args:
            return EXTREMES[name](*map(self._parameter_free, node.args))
        if operator is None:
            advice = advise_function(name, [*self.functions, *EXTREMES])
            self.source.fail("must call known functions", f"{name}(...)", advice, node)
        if len(node.args) != operator.arity:
            constraint = f"must give {name} {operator.arity} argument(s)"
            self.source.fail(constraint, str(len(node.args)), "Separate them by commas.", node)
        arguments = [self._parameter_free(argument) for argument in node.args]
        if any(argument.variables for argument in arguments):
            if operator == BUILTIN["sqrt"]:
                return real_power(arguments[0], 0.5)
            return terms.call(operator, *arguments)
        values = [np.array([value_of(argument)]) for argument in arguments]
        with np.errstate(all="ignore"):
            return terms.constant(float(np.asarray(operator(*values)).ravel()[0]))

    def _parameter_free(self, node: ast.expr) -> Sum:
        value = self.value(node)
        if parameters := _parameters(value):
            what = f"{parameters[0]!r} inside a function or power"
            self._fail_nonlinear(what, parameters[:1], node)
        return value.get(None, Sum(()))

    def _fail_nonlinear(self, what: str, names: Collection[str], node: ast.expr) -> None:
        advice = advise_parameter(names, self.columns, self.inputs, self.known)
        self.source.fail("must be linear in its free parameters", what, advice, node)


def _parameters(value: _Linear) -> list[str]:
    return [name for name in value if name is not None]


def _total(sums: list[Sum]) -> Sum:
    """Add in pairs, as adding one by one costs the square of their number."""
    while len(sums) > 1:
        pairs = [terms.add(a, b) for a, b in zip(sums[::2], sums[1::2], strict=False)]
        sums = pairs + sums[len(sums) - len(sums) % 2 :]
    return sums[0]


def real_power(base: Sum, exponent: float) -> Sum:
    """Return an integer power, x^n sqrt(x) for halves, exp(p log(x)) for all others.

    A power of max(x, 0) takes that of |x| where x is positive, as x + |x| may round below zero.
    """
    whole = int(exponent)
    if exponent == whole:
        return terms.power(base, whole)
    x = positive_part_of(base) if exponent > 0.0 else None
    if x is not None:
        is_positive = terms.add(terms.constant(1.0), terms.call(BUILTIN["sgn"], x))
        root = real_power(terms.call(BUILTIN["abs"], x), exponent - whole)
        beyond = terms.mul(terms.power(x, whole), root)
        return terms.mul(terms.constant(0.5), terms.mul(is_positive, beyond))
    if abs(exponent - whole) == 0.5:
        root = terms.call(BUILTIN["sqrt"], base)
        result = terms.mul(real_power(base, abs(whole)), root)
        return result if exponent > 0.0 else terms.power(result, -1)
    log = terms.call(BUILTIN["log"], base)
    return terms.call(BUILTIN["exp"], terms.mul(terms.constant(exponent), log))
