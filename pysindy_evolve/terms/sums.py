"""A linear combination of terms."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np

from ..lazily import lazily
from .atoms import Call, Variable
from .node import Cache, Node, take
from .products import ONE, Product

Term = TypeVar("Term")  # of this package, or of sympy


def signed(parts: Iterable[tuple[float, Term]]) -> Iterator[tuple[str, float, Term]]:
    """Yield sign, size and term of each part; a leading plus is left out."""
    for place, (coefficient, term) in enumerate(parts):
        yield "-" if coefficient < 0 else "+" if place else "", abs(coefficient), term


def join_terms(
    parts: Iterable[tuple[float, Term]], number: Callable[[float], str], term: Callable[[Term], str]
) -> str:
    """Write coefficients times terms with the signs between them.

    Parameters
    ----------
    parts : iterable of (float, term)
        Coefficients and terms, in the order in which they are written.
    number, term : callable
        Print a positive number, and a term; the term 1 prints as an empty string.

    Returns
    -------
    str
    """
    text = ""
    for sign, size, product in signed(parts):
        scale, body = number(size), term(product)
        if body.startswith("1/"):  # 24/v, not 24 1/v
            body = f"{scale}{body[1:]}"
        elif not body or scale != "1":
            body = f"{scale} {body}".rstrip()
        text += f" {sign} {body}" if text else f"{sign}{body}"
    return text or "0"


@dataclass(frozen=True)
class Sum(Node):
    """A linear combination of terms, sorted, each term once, no coefficient zero."""

    parts: tuple[tuple[float, Product], ...]

    __hash__ = Node.__hash__

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
        return join_terms(self.parts, _number, lambda term: "" if term == ONE else term.name(names))

    def factor_name(self, names: Sequence[str]) -> str:
        """Return the printed form in brackets."""
        return f"({self.name(names)})"

    def to_sympy(self, symbols: Sequence[Any]) -> Any:
        """Return the sympy expression."""
        zero = 0 * symbols[0] if len(symbols) else 0
        return sum((_exact(c) * term.to_sympy(symbols) for c, term in self.parts), start=zero)

    @property
    def children(self) -> tuple[Product, ...]:
        """Nodes one level below: the terms."""
        return tuple(term for _, term in self.parts)

    @lazily
    def size(self) -> int:
        """Number of nodes: of terms and additions, and one for each coefficient but 1 and -1."""
        joints = max(len(self.parts) - 1, 0) + sum(abs(c) != 1.0 for c, _ in self.parts)
        return joints + sum(term.size for _, term in self.parts)

    @lazily
    def depth(self) -> int:
        """Height of the tree."""
        if not self.parts:
            return 0
        return (len(self.parts) > 1) + max(term.depth for _, term in self.parts)

    @lazily
    def variables(self) -> frozenset[int]:
        """Columns of the data that the value depends on."""
        return frozenset().union(*(term.variables for _, term in self.parts))

    @lazily
    def constants(self) -> tuple[float, ...]:
        """The constant, and all coefficients but 1 and -1, each before those inside its term."""
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
            parts.append((new, term.with_constants(take(rest, term))))
        return collect(parts)


Atom = Variable | Call | Sum


def as_sum(atom: Atom) -> Sum:
    """Return a sum of one atom and nothing else."""
    return of_term(Product(((atom, 1),)))


def of_term(term: Product) -> Sum:
    """Return a sum of one term and nothing else."""
    return Sum(((1.0, term),))


def only_term(a: Sum) -> Product:
    """Return the term of a sum that has no other, without its coefficient."""
    ((_, term),) = a.parts
    return term


def value_of(number: Sum) -> float:
    """Return the value of a sum without variables."""
    return float(number.evaluate(np.empty((1, 0)))[0])


def only_atom(a: Sum) -> Atom | None:
    """Return the atom that a sum is, such as v or sgn(v); None if it is anything else."""
    if len(a.parts) != 1 or a.parts[0][0] != 1.0:
        return None
    factors = a.parts[0][1].factors
    return factors[0][0] if len(factors) == 1 and factors[0][1] == 1 else None


def as_product(a: Sum) -> Product:
    """Return a sum as one term; a sum such as 1 + 2 q becomes one atom."""
    if len(a.parts) == 1 and a.parts[0][0] == 1.0:
        return a.parts[0][1]
    return Product(((a, 1),))


def collect(parts: Iterable[tuple[float, Product]]) -> Sum:
    """Return the sum of coefficients times terms, like terms collected and sorted."""
    totals: dict[Product, float] = {}
    for coefficient, term in parts:
        totals[term] = totals.get(term, 0.0) + coefficient
    kept = [(c, term) for term, c in totals.items() if c != 0.0]
    if len(kept) > 1:
        kept.sort(key=lambda part: part[1].key)
    return Sum(tuple(kept))


def _is_free(coefficient: float, term: Product) -> bool:
    """Tell whether a coefficient is an inner constant; a bare 1 or -1 beside a term is not."""
    return abs(coefficient) != 1.0 or term == ONE


def _number(value: float) -> str:
    return f"{value:.4g}"


def _exact(value: float) -> int | float:
    """Return whole numbers as int, so that sympy prints v and not 1.0*v."""
    return int(value) if abs(value) < 2**53 and value == int(value) else value
