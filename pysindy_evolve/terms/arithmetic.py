"""Arithmetic on sums: multiplied out and collected, so that every expression has one form."""

from __future__ import annotations

import math
from collections.abc import Iterable

from ..operators import BUILTIN
from .atoms import Call, Variable
from .canonical import multiply, simplified
from .products import ONE, Product
from .sums import Sum, as_sum, collect

MAX_PARTS = 64  # a result with more parts is not multiplied out
MAX_DEGREE = 8  # nor is a higher power: (q + v)^40 near q = -v would lose all its digits


def variable(index: int) -> Sum:
    """Return column `index` of the data as a sum."""
    return as_sum(Variable(index))


def constant(value: float) -> Sum:
    """Return a number as a sum."""
    return Sum(((float(value), ONE),)) if value else Sum(())


def neg(a: Sum) -> Sum:
    """Return -a."""
    return Sum(tuple((-c, term) for c, term in a.parts))


def add(a: Sum, b: Sum) -> Sum:
    """Return a + b, like terms collected."""
    return collect((*a.parts, *b.parts))


def sub(a: Sum, b: Sum) -> Sum:
    """Return a - b, like terms collected."""
    return add(a, neg(b))


def mul(a: Sum, b: Sum) -> Sum:
    """Return a * b, multiplied out unless that gives more than `MAX_PARTS` parts."""
    if len(a.parts) * len(b.parts) > MAX_PARTS:
        a, b = as_atom(a), as_atom(b)
    return _distributed(a, b)


def div(a: Sum, b: Sum) -> Sum:
    """Return a / b; a sum in the denominator becomes one atom, with 1 as its last coefficient."""
    ratio = _common_factor(a, b)
    return mul(a, power(b, -1)) if ratio is None else constant(ratio)


def power(a: Sum, exponent: int) -> Sum:
    """Return a to an integer power, multiplied out, or with the sum as one atom if it is long."""
    if exponent in (0, 1):
        return a if exponent else constant(1.0)
    if not a.parts:
        # 1/0 has no value anywhere, like log(-1); terms without finite values are rejected.
        return a if exponent > 0 else as_sum(Call(BUILTIN["log"], (neg(constant(1.0)),)))
    if exponent > 0 and len(a.parts) > 1 and _n_opened(a, exponent) <= MAX_PARTS:
        result = a
        for _ in range(exponent - 1):
            result = _distributed(result, a)
        return result
    ((coefficient, term),) = as_atom(a).parts
    raised = simplified(tuple((atom, n * exponent) for atom, n in term.factors))
    scale = _float_power(coefficient, exponent)
    return Sum(tuple(_multiplied_out(scale, raised))) if scale else Sum(())


def as_atom(a: Sum) -> Sum:
    """Return a sum of one term: itself, or (its last coefficient) times a sum as an atom.

    The last term is never the constant, so that x/(c + x) has one inner constant, not two.
    """
    if len(a.parts) <= 1:
        return a
    leading = a.parts[-1][0]
    scaled = Sum(tuple((c / leading, term) for c, term in a.parts))
    return Sum(((leading, Product(((scaled, 1),))),))


def _distributed(a: Sum, b: Sum) -> Sum:
    products = [(c * d, multiply(p, q)) for c, p in a.parts for d, q in b.parts]
    return collect(part for c, product in products for part in _multiplied_out(c, product))


def _common_factor(a: Sum, b: Sum) -> float | None:
    """Return a / b if it is a number: both are sums of the same terms, in the same proportions."""
    if len(a.parts) != len(b.parts) or len(a.parts) < 2:
        return None
    ratio = a.parts[-1][0] / b.parts[-1][0]
    pairs = zip(a.parts, b.parts, strict=True)
    # Coefficients may differ by rounding, as in (0.1 q + 0.3 v) / (0.2 q + 0.6 v).
    same = all(p == q and math.isclose(c, ratio * d, rel_tol=1e-14) for (c, p), (d, q) in pairs)
    return ratio if same else None


def _multiplied_out(coefficient: float, term: Product) -> Iterable[tuple[float, Product]]:
    """Multiply out short sums among the factors, such as from abs(q + v) sgn(q + v) = q + v."""
    sums = [(atom, n) for atom, n in term.factors if isinstance(atom, Sum) and n > 0]
    if not sums or math.prod(_n_opened(atom, n) for atom, n in sums) > MAX_PARTS:
        return [(coefficient, term)]
    rest = Product(tuple(factor for factor in term.factors if factor not in sums))
    result = Sum(((coefficient, rest),))
    for atom, n in sums:
        result = _distributed(result, power(atom, n))
    return result.parts


def _n_opened(a: Sum, exponent: int) -> int:
    """Count the parts of a sum to a positive power, multiplied out."""
    if exponent > MAX_DEGREE:
        return MAX_PARTS + 1
    return math.comb(len(a.parts) + exponent - 1, exponent)


def _float_power(value: float, exponent: int) -> float:
    """Return a power as repeated products give it: infinity, not an error, on overflow."""
    try:
        return value**exponent
    except OverflowError:
        return math.copysign(math.inf, value) if exponent % 2 else math.inf
