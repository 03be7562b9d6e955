"""Atoms: a column of the data, and an operator applied to sums."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..lazily import lazily
from ..operators import Operator
from .node import Cache, Node, take

if TYPE_CHECKING:
    from .sums import Sum


@dataclass(frozen=True)
class Variable(Node):
    """One column of the data."""

    __hash__ = Node.__hash__

    index: int

    @lazily
    def key(self) -> tuple[Any, ...]:
        """Sort key: in the order of the columns."""
        return (0, self.index, "")

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
    def children(self) -> tuple[()]:
        """Nodes one level below: none."""
        return ()

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
class Call(Node):
    """An operator applied to sums."""

    operator: Operator
    args: tuple[Sum, ...]

    __hash__ = Node.__hash__

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

    @property
    def children(self) -> tuple[Sum, ...]:
        """Nodes one level below: the arguments."""
        return self.args

    @lazily
    def size(self) -> int:
        """Number of nodes; x^1.75, which is exp(1.75 log(x)), has two besides those of x."""
        return (0 if self.is_power else 1) + sum(a.size for a in self.args)

    @property
    def is_power(self) -> bool:
        """Whether this is exp(n log(x)), which is printed as x^n."""
        factors = [factor for a in self.args for _, term in a.parts for factor in term.factors]
        if self.operator.name != "exp" or len(factors) != 1:
            return False
        ((atom, exponent),) = factors
        return exponent == 1 and isinstance(atom, Call) and atom.operator.name == "log"

    @lazily
    def depth(self) -> int:
        """Height of the tree."""
        return 1 + max(a.depth for a in self.args)

    @lazily
    def variables(self) -> frozenset[int]:
        """Columns of the data that the value depends on."""
        return frozenset().union(*(a.variables for a in self.args))

    @lazily
    def constants(self) -> tuple[float, ...]:
        """Inner constants, from left to right."""
        return tuple(c for a in self.args for c in a.constants)

    def with_constants(self, values: Sequence[float]) -> Call:
        """Return the same call with other inner constants."""
        rest = iter(values)
        return Call(self.operator, tuple(a.with_constants(take(rest, a)) for a in self.args))
