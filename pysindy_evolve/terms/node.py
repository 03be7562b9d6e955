"""The base of all nodes of an expression: hash, order and pickling."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import fields
from operator import attrgetter
from typing import Any

import numpy as np

from ..lazily import lazily

Cache = dict[Any, np.ndarray]  # values of subtrees on the same x


class Node:
    """Base of all nodes; its cached hash and sort key are not pickled.

    Hashes of strings differ from process to process, so a pickled hash would be wrong.
    """

    def __getstate__(self) -> dict[str, Any]:
        return {field.name: getattr(self, field.name) for field in fields(self)}  # type: ignore[arg-type]

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)

    @lazily
    def _hash(self) -> int:
        # __match_args__ are the fields of a dataclass, many times faster to reach than fields().
        return hash(attrgetter(*self.__match_args__)(self))  # type: ignore[attr-defined]

    def __hash__(self) -> int:
        return self._hash

    @lazily
    def key(self) -> tuple[Any, ...]:
        """Sort key: the constant and plain variables first, then by size and printed form."""
        return (1, self.size, _PrintedForm(self))  # type: ignore[attr-defined]

    def factor_name(self, names: Sequence[str]) -> str:
        """Return the printed form inside a product."""
        return self.name(names)  # type: ignore[attr-defined]


class _PrintedForm:
    """A node's printed form in a sort key, computed only if the parts before it are equal."""

    def __init__(self, node: Any) -> None:
        self.node = node

    @lazily
    def text(self) -> str:
        return self.node.name(_COLUMN_NAMES)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, _PrintedForm):
            return NotImplemented
        return self.node is other.node or self.text == other.text

    def __hash__(self) -> int:
        return hash(self.text)

    def __lt__(self, other: _PrintedForm) -> bool:
        return self.text < other.text


class _ColumnNames(Sequence[str]):
    """Names x0, x1, ... without end."""

    def __getitem__(self, index: Any) -> Any:
        return f"x{index}"

    def __len__(self) -> int:
        return 0


_COLUMN_NAMES = _ColumnNames()


def take(rest: Iterator[float], node: Any) -> list[float]:
    """Take from a stream of inner constants as many as a node has."""
    return [next(rest) for _ in node.constants]
