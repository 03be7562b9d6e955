"""A term: a product of integer powers of atoms."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..lazily import lazily
from .node import Cache, Node, take

if TYPE_CHECKING:
    from .sums import Atom


@dataclass(frozen=True)
class Product(Node):
    """A term: a product of integer powers of atoms, sorted, each atom once, no power zero."""

    factors: tuple[tuple[Atom, int], ...]

    __hash__ = Node.__hash__

    @lazily
    def key(self) -> tuple[Any, ...]:
        """Sort key: the constant term before all others."""
        return super().key if self.factors else (0, -1, "")

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
            May hold values that are not finite: no operator is protected.
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
        numerator = " ".join(_power_name(a, n, names) for a, n in self.factors if n > 0)
        denominator = " ".join(_power_name(a, -n, names) for a, n in self.factors if n < 0)
        if not denominator:
            return numerator or "1"
        several = sum(n < 0 for _, n in self.factors) > 1
        return f"{numerator or '1'}/{f'({denominator})' if several else denominator}"

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
        unit = symbols[0] ** 0 if len(symbols) else 1
        return math.prod((a.to_sympy(symbols) ** n for a, n in self.factors), start=unit)

    @property
    def children(self) -> tuple[Atom, ...]:
        """Nodes one level below: the atoms."""
        return tuple(atom for atom, _ in self.factors)

    @lazily
    def size(self) -> int:
        """Number of nodes; a power counts as one node above its atom."""
        joints = max(len(self.factors) - 1, 0) + sum(n != 1 for _, n in self.factors)
        return max(joints + sum(atom.size for atom, _ in self.factors), 1)

    @lazily
    def depth(self) -> int:
        """Height of the tree."""
        if not self.factors:
            return 0
        powers = any(n != 1 for _, n in self.factors)
        return (len(self.factors) > 1) + powers + max(atom.depth for atom, _ in self.factors)

    @lazily
    def variables(self) -> frozenset[int]:
        """Columns of the data that the value depends on."""
        return frozenset().union(*(atom.variables for atom, _ in self.factors))

    @lazily
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
        return Product(tuple((a.with_constants(take(rest, a)), n) for a, n in self.factors))

    def without(self, place: int) -> Product:
        """Return the same term without the factor at a place."""
        return Product(self.factors[:place] + self.factors[place + 1 :])

    @lazily
    def skeleton(self) -> Product:
        """The term with its inner constants replaced by markers; itself if it has none."""
        markers = [2.0 + i for i in range(len(self.constants))]
        return self.with_constants(markers) if markers else self


ONE = Product(())


def _integer_power(value: np.ndarray, exponent: int) -> np.ndarray:
    """Take powers by repeated products: much faster than np.power, and exact for squares."""
    magnitude = abs(exponent)
    result = value
    for _ in range(magnitude - 1):
        result = result * value
    return result if exponent > 0 else 1.0 / result


def _power_name(atom: Atom, exponent: int, names: Sequence[str]) -> str:
    text = atom.factor_name(names)
    return text if exponent == 1 else f"{text}^{exponent}"
