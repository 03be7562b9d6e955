"""Terms: what a column of the library is made of.

A *term* is a product of integer powers of atoms; a *sum* is a linear combination of terms; an
*atom* is a variable, an operator applied to sums, or a sum. ::

    Product   q^2 sgn(v)          ((q, 2), (sgn(v), 1))
    Sum       0.5 + q             ((0.5, ONE), (1.0, q))
    Call      sin(2.1 q + 0.3)    (sin, (Sum,))
    Variable  q                   column 0

Arithmetic on sums multiplies out and collects, so every expression has one form: q*(q*q) and
cube(q) are the same term, and v*sgn(v) is abs(v). All classes are immutable, hash and pickle.
Floats inside an atom (the 2.1 and 0.3 above) are the *inner constants* of a term.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any

import numpy as np

from .operators import BUILTIN, Operator

__all__ = [
    "ONE", "Atom", "Call", "Product", "Sum", "Variable",
    "add", "call", "constant", "div", "mul", "neg", "power", "sub", "variable",
]  # fmt: skip

Cache = dict[Any, np.ndarray]
MAX_PARTS = 64  # what would have more parts than this is not multiplied out
MAX_DEGREE = 8  # nor is a higher power: (q + v)^40 near q = -v would lose all its digits


class _Node:
    """What all nodes share: cached hash and sort key, which do not travel in a pickle.

    Hashes of strings differ from process to process, so a pickled hash would be a wrong one.
    """

    def __getstate__(self) -> dict[str, Any]:
        return {field.name: getattr(self, field.name) for field in fields(self)}  # type: ignore[arg-type]

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)

    @cached_property
    def _hash(self) -> int:
        # __match_args__ are the fields of a dataclass, five times faster to reach than fields().
        return hash(tuple(getattr(self, name) for name in self.__match_args__))  # type: ignore[attr-defined]

    def __hash__(self) -> int:
        return self._hash

    @cached_property
    def _key(self) -> tuple[Any, ...]:
        """Sort the constant and plain variables first, then by size and printed form."""
        if isinstance(self, Variable):
            return (0, self.index, "")
        if self == ONE:
            return (0, -1, "")
        return (1, self.size, self.name(_COLUMN_NAMES))  # type: ignore[attr-defined]


@dataclass(frozen=True)
class Variable(_Node):
    """One column of the data."""

    __hash__ = _Node.__hash__

    index: int

    def evaluate(self, x: np.ndarray, cache: Cache | None = None) -> np.ndarray:
        """Return column `index` of x, shape (n_samples,)."""
        return x[:, self.index]

    def name(self, names: Sequence[str]) -> str:
        """Return the name of the column."""
        return names[self.index]

    def to_sympy(self, symbols: Sequence[Any]) -> Any:
        """Return the symbol of the column."""
        return symbols[self.index]

    @property
    def size(self) -> int:
        """Number of nodes: one."""
        return 1

    @property
    def depth(self) -> int:
        """Height of the tree: zero for a leaf."""
        return 0

    @property
    def variables(self) -> frozenset[int]:
        """Columns of the data that the value depends on."""
        return frozenset((self.index,))

    @property
    def constants(self) -> tuple[float, ...]:
        """Inner constants: none."""
        return ()

    def with_constants(self, values: Sequence[float]) -> Variable:
        """Return the variable itself, which has no constants to replace."""
        return self


@dataclass(frozen=True)
class Call(_Node):
    """An operator applied to sums."""

    operator: Operator
    args: tuple[Sum, ...]

    __hash__ = _Node.__hash__

    def evaluate(self, x: np.ndarray, cache: Cache | None = None) -> np.ndarray:
        """Return the value at each row of x, shape (n_samples,)."""
        if cache is not None and self in cache:
            return cache[self]
        arguments = [argument.evaluate(x, cache) for argument in self.args]
        with np.errstate(all="ignore"):
            value = np.asarray(self.operator(*arguments), dtype=float)
        if cache is not None:
            cache[self] = value
        return value

    def name(self, names: Sequence[str]) -> str:
        """Return the printed form, such as ``sgn(v)``."""
        return f"{self.operator.name}({', '.join(a.name(names) for a in self.args)})"

    def to_sympy(self, symbols: Sequence[Any]) -> Any:
        """Return the sympy expression."""
        return self.operator.to_sympy(*(a.to_sympy(symbols) for a in self.args))

    @cached_property
    def size(self) -> int:
        """Number of nodes."""
        return 1 + sum(a.size for a in self.args)

    @cached_property
    def depth(self) -> int:
        """Height of the tree."""
        return 1 + max(a.depth for a in self.args)

    @cached_property
    def variables(self) -> frozenset[int]:
        """Columns of the data that the value depends on."""
        return frozenset().union(*(a.variables for a in self.args))

    @cached_property
    def constants(self) -> tuple[float, ...]:
        """Inner constants, from left to right."""
        return tuple(c for a in self.args for c in a.constants)

    def with_constants(self, values: Sequence[float]) -> Call:
        """Return the same call with other inner constants."""
        rest = iter(values)
        return Call(self.operator, tuple(a.with_constants(_take(rest, a)) for a in self.args))


@dataclass(frozen=True)
class Sum(_Node):
    """A linear combination of terms, sorted, each term once, no coefficient zero."""

    parts: tuple[tuple[float, Product], ...]

    __hash__ = _Node.__hash__

    def evaluate(self, x: np.ndarray, cache: Cache | None = None) -> np.ndarray:
        """Return the value at each row of x, shape (n_samples,)."""
        value = np.zeros(len(x))
        with np.errstate(all="ignore"):
            for coefficient, term in self.parts:
                column = term.evaluate(x, cache)
                value = value + (column if coefficient == 1.0 else coefficient * column)
        return value

    def name(self, names: Sequence[str]) -> str:
        """Return the printed form, such as ``0.5 + q``."""
        if not self.parts:
            return "0"
        text = ""
        for coefficient, term in self.parts:
            sign = "-" if coefficient < 0 else "+" if text else ""
            size = _number(abs(coefficient))
            body = size if term == ONE else term.name(names)
            if term != ONE and size != "1":
                body = f"{size} {body}"
            text += f" {sign} {body}" if text else f"{sign}{body}"
        return text

    def to_sympy(self, symbols: Sequence[Any]) -> Any:
        """Return the sympy expression."""
        zero = 0 * symbols[0] if len(symbols) else 0
        return sum((_exact(c) * term.to_sympy(symbols) for c, term in self.parts), start=zero)

    @cached_property
    def size(self) -> int:
        """Number of nodes: of the terms, and one for each coefficient that is not one."""
        own = max(len(self.parts) - 1, 0) + sum(abs(c) != 1.0 for c, _ in self.parts)
        return own + sum(term.size for _, term in self.parts)

    @cached_property
    def depth(self) -> int:
        """Height of the tree."""
        if not self.parts:
            return 0
        return (len(self.parts) > 1) + max(term.depth for _, term in self.parts)

    @cached_property
    def variables(self) -> frozenset[int]:
        """Columns of the data that the value depends on."""
        return frozenset().union(*(term.variables for _, term in self.parts))

    @cached_property
    def constants(self) -> tuple[float, ...]:
        """Coefficients other than one and minus one, each before the constants of its term."""
        return tuple(
            c
            for coefficient, term in self.parts
            for c in ((coefficient,) if _is_free(coefficient, term) else ()) + term.constants
        )

    def with_constants(self, values: Sequence[float]) -> Sum:
        """Return the same sum with other constants, in the order of `constants`."""
        rest = iter(values)
        parts = []
        for coefficient, term in self.parts:
            free = _is_free(coefficient, term)
            new = float(next(rest)) if free else coefficient
            parts.append((new, term.with_constants(_take(rest, term))))
        return _collect(parts)


@dataclass(frozen=True)
class Product(_Node):
    """A term: a product of integer powers of atoms, sorted, each atom once, no power zero."""

    factors: tuple[tuple[Atom, int], ...]

    __hash__ = _Node.__hash__

    def evaluate(self, x: np.ndarray, cache: Cache | None = None) -> np.ndarray:
        """Return the column of theta that belongs to this term.

        Parameters
        ----------
        x : ndarray of shape (n_samples, n_variables)
            Values of the variables.
        cache : dict, optional
            Values of subtrees, shared between terms that are evaluated on the same x.

        Returns
        -------
        ndarray of shape (n_samples,)
            May hold values that are not finite: nothing is protected.
        """
        if cache is not None and self in cache:
            return cache[self]
        value: np.ndarray | None = None
        with np.errstate(all="ignore"):
            for atom, exponent in self.factors:
                factor = _integer_power(atom.evaluate(x, cache), exponent)
                value = factor if value is None else value * factor
        result = np.ones(len(x)) if value is None else np.asarray(value)
        if cache is not None:
            cache[self] = result
        return result

    def name(self, names: Sequence[str]) -> str:
        """Return the printed form, such as ``q^2 sgn(v)`` or ``q/(0.5 + q)``."""
        above = " ".join(_power_name(a, n, names) for a, n in self.factors if n > 0)
        below = " ".join(_power_name(a, -n, names) for a, n in self.factors if n < 0)
        if not below:
            return above or "1"
        many = sum(n < 0 for _, n in self.factors) > 1
        return f"{above or '1'}/{f'({below})' if many else below}"

    def to_sympy(self, symbols: Sequence[Any]) -> Any:
        """Return the sympy expression.

        Parameters
        ----------
        symbols : sequence of sympy.Symbol
            One for each variable.

        Returns
        -------
        sympy.Expr
        """
        one = symbols[0] ** 0 if len(symbols) else 1
        return math.prod((a.to_sympy(symbols) ** n for a, n in self.factors), start=one)

    @cached_property
    def size(self) -> int:
        """Number of nodes; a power counts as one node above its atom."""
        own = max(len(self.factors) - 1, 0) + sum(n != 1 for _, n in self.factors)
        return max(own + sum(atom.size for atom, _ in self.factors), 1)

    @cached_property
    def depth(self) -> int:
        """Height of the tree."""
        if not self.factors:
            return 0
        powers = any(n != 1 for _, n in self.factors)
        return (len(self.factors) > 1) + powers + max(atom.depth for atom, _ in self.factors)

    @cached_property
    def variables(self) -> frozenset[int]:
        """Columns of the data that the value depends on."""
        return frozenset().union(*(atom.variables for atom, _ in self.factors))

    @cached_property
    def constants(self) -> tuple[float, ...]:
        """Inner constants, from left to right."""
        return tuple(c for atom, _ in self.factors for c in atom.constants)

    def with_constants(self, values: Sequence[float]) -> Product:
        """Return the same term with other inner constants.

        Parameters
        ----------
        values : sequence of float
            As many as `constants`, in its order.

        Returns
        -------
        Product
        """
        rest = iter(values)
        return Product(tuple((a.with_constants(_take(rest, a)), n) for a, n in self.factors))


Atom = Variable | Call | Sum
ONE = Product(())


def variable(index: int) -> Sum:
    """Return column `index` of the data as a sum."""
    return Sum(((1.0, Product(((Variable(index), 1),))),))


def constant(value: float) -> Sum:
    """Return a number as a sum."""
    return Sum(((float(value), ONE),)) if value else Sum(())


def neg(a: Sum) -> Sum:
    """Return -a."""
    return Sum(tuple((-c, term) for c, term in a.parts))


def add(a: Sum, b: Sum) -> Sum:
    """Return a + b, like terms collected."""
    return _collect((*a.parts, *b.parts))


def sub(a: Sum, b: Sum) -> Sum:
    """Return a - b, like terms collected."""
    return add(a, neg(b))


def mul(a: Sum, b: Sum) -> Sum:
    """Return a * b, multiplied out unless that gives more than `MAX_PARTS` parts."""
    if len(a.parts) * len(b.parts) > MAX_PARTS:
        a, b = _as_atom(a), _as_atom(b)
    return _distributed(a, b)


def div(a: Sum, b: Sum) -> Sum:
    """Return a / b; a sum below the line stays one, with its last coefficient made one."""
    ratio = _common_factor(a, b)
    return mul(a, power(b, -1)) if ratio is None else constant(ratio)


def power(a: Sum, exponent: int) -> Sum:
    """Return a to an integer power, multiplied out or, if that is long, with the sum as one."""
    if exponent in (0, 1):
        return a if exponent else constant(1.0)
    if not a.parts:
        # Zero below the line is not finite anywhere: rejected.
        return a if exponent > 0 else _as_call(BUILTIN["log"], (neg(constant(1.0)),))
    if exponent > 0 and len(a.parts) > 1 and _n_opened(a, exponent) <= MAX_PARTS:
        result = a
        for _ in range(exponent - 1):
            result = _distributed(result, a)
        return result
    ((coefficient, term),) = _as_atom(a).parts
    raised = _simplified(tuple((atom, n * exponent) for atom, n in term.factors))
    scale = _float_power(coefficient, exponent)
    return Sum(tuple(_multiplied_out(scale, raised))) if scale else Sum(())


def call(operator: Operator, *args: Sum) -> Sum:
    """Return operator(*args) in its one form; arithmetic operators are carried out.

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
        return _as_call(operator, args)
    if operator.name in _ARITHMETIC:
        return _ARITHMETIC[operator.name](*args)
    (argument,) = args
    if not argument.variables:
        return _of_constant(operator, argument)
    if operator.name in ("abs", "sgn"):
        return _magnitude_or_sign(operator, argument)
    if operator.name in _ODD and argument.parts[0][0] < 0:
        return neg(_as_call(operator, (neg(argument),)))
    if operator.name == "cos" and argument.parts[0][0] < 0:
        argument = neg(argument)
    return _as_call(operator, (argument,))


_ODD = ("sin", "tan", "tanh")
_ARITHMETIC: dict[str, Callable[..., Sum]] = {
    "add": add,
    "sub": sub,
    "mul": mul,
    "div": div,
    "neg": neg,
    "square": lambda a: power(a, 2),
    "cube": lambda a: power(a, 3),
}


def _as_call(operator: Operator, args: tuple[Sum, ...]) -> Sum:
    return Sum(((1.0, Product(((Call(operator, args), 1),))),))


def _of_constant(operator: Operator, argument: Sum) -> Sum:
    with np.errstate(all="ignore"):
        value = float(operator(argument.evaluate(np.empty((1, 0))))[0])
    return constant(value) if math.isfinite(value) else _as_call(operator, (argument,))


def _magnitude_or_sign(operator: Operator, argument: Sum) -> Sum:
    """Apply abs or sgn factor by factor: abs(2 q v) = 2 abs(q) abs(v)."""
    ((coefficient, term),) = _as_atom(argument).parts
    sign = operator.name == "sgn"
    result = constant(math.copysign(1.0, coefficient) if sign else abs(coefficient))
    for atom, exponent in term.factors:
        for _ in range(abs(exponent)):
            factor = _magnitude_or_sign_of_atom(operator, atom)
            # 1/sgn would differ from sgn at zero only, where 1/x has no value anyway.
            result = mul(result, factor) if exponent > 0 else div(result, factor)
    return result


def _magnitude_or_sign_of_atom(operator: Operator, atom: Atom) -> Sum:
    itself = Sum(((1.0, Product(((atom, 1),))),))
    if isinstance(atom, Call) and atom.operator == BUILTIN["sgn"]:
        return itself if operator.name == "sgn" else mul(itself, itself)
    if isinstance(atom, Call) and atom.operator == BUILTIN["abs"]:
        inner = _as_call(BUILTIN["sgn"], atom.args)
        return itself if operator.name == "abs" else mul(inner, inner)
    return _as_call(operator, (atom if isinstance(atom, Sum) else itself,))


def _as_atom(a: Sum) -> Sum:
    """Return a sum of one term: itself, or (its last coefficient) times a sum as an atom.

    The last term is never the constant one, so that x/(c + x) has one inner constant and not two.
    """
    if len(a.parts) <= 1:
        return a
    leading = a.parts[-1][0]
    scaled = Sum(tuple((c / leading, term) for c, term in a.parts))
    return Sum(((leading, Product(((scaled, 1),))),))


def _distributed(a: Sum, b: Sum) -> Sum:
    products = [(c * d, _multiply(p, q)) for c, p in a.parts for d, q in b.parts]
    return _collect(part for c, product in products for part in _multiplied_out(c, product))


def _common_factor(a: Sum, b: Sum) -> float | None:
    """Return the number that a is of b, where both are sums of the same terms."""
    if len(a.parts) != len(b.parts) or len(a.parts) < 2:
        return None
    ratio = a.parts[-1][0] / b.parts[-1][0]
    pairs = zip(a.parts, b.parts, strict=True)
    # Rounding of the coefficients, such as of 0.1 q + 0.3 v over 0.2 q + 0.6 v, counts as none.
    same = all(p == q and math.isclose(c, ratio * d, rel_tol=1e-14) for (c, p), (d, q) in pairs)
    return ratio if same else None


def _multiplied_out(coefficient: float, term: Product) -> Iterable[tuple[float, Product]]:
    """Open short sums that abs(q + v) sgn(q + v) = q + v has brought above the line."""
    above = [(atom, n) for atom, n in term.factors if isinstance(atom, Sum) and n > 0]
    if not above or math.prod(_n_opened(atom, n) for atom, n in above) > MAX_PARTS:
        return [(coefficient, term)]
    rest = Product(tuple(factor for factor in term.factors if factor not in above))
    result = Sum(((coefficient, rest),))
    for atom, n in above:
        result = _distributed(result, power(atom, n))
    return result.parts


def _n_opened(a: Sum, exponent: int) -> int:
    """Count the parts of a sum to a positive power, multiplied out."""
    if exponent > MAX_DEGREE:
        return MAX_PARTS + 1
    return math.comb(len(a.parts) + exponent - 1, exponent)


def _float_power(value: float, exponent: int) -> float:
    """Return what repeated products would: infinity, not an error, beyond the largest float."""
    try:
        return value**exponent
    except OverflowError:
        return math.copysign(math.inf, value) if exponent % 2 else math.inf


def _multiply(p: Product, q: Product) -> Product:
    exponents: dict[Atom, int] = dict(p.factors)
    for atom, n in q.factors:
        exponents[atom] = exponents.get(atom, 0) + n
    return _simplified(tuple((atom, n) for atom, n in exponents.items() if n))


def _simplified(factors: tuple[tuple[Atom, int], ...]) -> Product:
    """Apply x sgn(x) = abs(x), abs(x) sgn(x) = x, abs(x)^2 = x^2, sgn(x)^3 = sgn(x); sort."""
    exponents = dict(factors)
    for atom in list(exponents):
        if isinstance(atom, Call) and atom.operator in (BUILTIN["sgn"], BUILTIN["abs"]):
            _fold(exponents, atom.args[0])
    return Product(tuple(sorted(((a, n) for a, n in exponents.items() if n), key=_order)))


def _fold(exponents: dict[Atom, int], argument: Sum) -> None:
    """Bring x^n abs(x)^a sgn(x)^s to its one form: at most one abs or sgn remains beside x^n."""
    base: Atom = argument
    if len(argument.parts) == 1 and argument.parts[0][0] == 1.0:
        factors = argument.parts[0][1].factors
        base = factors[0][0] if len(factors) == 1 and factors[0][1] == 1 else argument
    sign, magnitude = Call(BUILTIN["sgn"], (argument,)), Call(BUILTIN["abs"], (argument,))
    n, a, s = (exponents.pop(key, 0) for key in (base, magnitude, sign))
    if s < 0:
        exponents.update({base: n, magnitude: a, sign: s})  # 1/sgn(0) has no value: left alone
        return
    odd = (a + s) % 2 == 1  # parity of the sign that is left over
    degree = n + a  # |x|^a = x^a sgn(x)^a
    if degree == 0 and n == 0:
        exponents[sign] = s if s < 2 else 2 - s % 2
        return
    if odd and degree != 0:
        exponents.update({base: degree - 1, magnitude: 1})
    elif odd:
        exponents[sign] = 1
    elif degree:
        exponents[base] = degree


def _collect(parts: Iterable[tuple[float, Product]]) -> Sum:
    totals: dict[Product, float] = {}
    for coefficient, term in parts:
        totals[term] = totals.get(term, 0.0) + coefficient
    kept = [(c, term) for term, c in totals.items() if c != 0.0]
    return Sum(tuple(sorted(kept, key=lambda part: part[1]._key)))


def _order(factor: tuple[Atom, int]) -> tuple[Any, ...]:
    return (*factor[0]._key, factor[1])


class _ColumnNames(Sequence[str]):
    """Names x0, x1, ... without end."""

    def __getitem__(self, index: Any) -> Any:
        return f"x{index}"

    def __len__(self) -> int:
        return 0


_COLUMN_NAMES = _ColumnNames()


def _is_free(coefficient: float, term: Product) -> bool:
    """Tell whether a coefficient is an inner constant; a bare 1 or -1 beside a term is not."""
    return abs(coefficient) != 1.0 or term == ONE


def _take(rest: Iterator[float], node: Any) -> list[float]:
    return [next(rest) for _ in node.constants]


def _integer_power(value: np.ndarray, exponent: int) -> np.ndarray:
    """Multiply out small powers, as many times faster than np.power and exact for squares."""
    magnitude = abs(exponent)
    result = value
    for _ in range(magnitude - 1):
        result = result * value
    return result if exponent > 0 else 1.0 / result


def _power_name(atom: Atom, exponent: int, names: Sequence[str]) -> str:
    text = f"({atom.name(names)})" if isinstance(atom, Sum) else atom.name(names)
    return text if exponent == 1 else f"{text}^{exponent}"


def _number(value: float) -> str:
    return f"{value:.4g}"


def _exact(value: float) -> int | float:
    """Return whole numbers as int, so that sympy prints v and not 1.0*v."""
    return int(value) if abs(value) < 2**53 and value == int(value) else value
