"""Hidden states that follow the path of a measured one, whatever they make of it.

A term of a model that remembers is an operator on the rows of a record in time order, of the
measured state first. Written out, it is a function of a hidden state, whose rate is linear in some
weights, so that these can be fitted as coefficients are:

======================  ==================================  ======================  ==========
kind                    hidden state                        weights                 term
======================  ==================================  ======================  ==========
friction, boucwen.py    w, between -1 and 1                 1 / L, k / L            w
spring, wen_spring.py   w                                   1 / L, beta / L         w
relaxation, relaxing.py h, within the range of the state x  1 / T                   x - h
mode, flexible_mode.py  h, h'                               w0^2, 2 D w0            h'' / w0^2
======================  ==================================  ======================  ==========
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import reduce
from typing import Any, Protocol, TypeGuard

import numpy as np

from ..equations import Equations
from ..operators import Operator
from ..substitution import substituted
from ..terms import Call, Sum, add, constant, mul
from .boucwen import BOUC_WEN, Hysteresis
from .flexible_mode import FLEXIBLE_MODE, FlexibleMode
from .relaxing import RELAXING, Relaxation
from .wen_spring import WEN_SPRING, SpringHysteresis

__all__ = ["PathKind", "hidden_along", "kind_of", "moved", "n_hidden_of", "own_states"]
__all__ += ["path_rates", "paths_in", "paths_within", "sayings", "source_of"]


class PathKind(Protocol):
    """What a model needs to know of the terms of one operator, its paths.

    There are `order` hidden states, each the rate of the one before; they go with the measured ones
    that come first in the operator, and `suffix` is what their names end in.
    """

    suffix: str
    order: int

    def numbers(self, path: Call) -> tuple[float, ...]:
        """Return the numbers that the operator is given."""
        ...

    def weights(self, path: Call) -> tuple[float, ...]:
        """Return the weights in the rate of the last hidden state."""
        ...

    def numbers_from(self, weights: np.ndarray) -> tuple[float, ...]:
        """Return the numbers from weights, the first of which is positive."""
        ...

    def parts(self, path: Call, states: Sequence[Sum]) -> tuple[Sum, ...]:
        """Return what the weights multiply in the rate of the last hidden state."""
        ...

    def term(self, path: Call, states: Sequence[Sum]) -> Sum:
        """Return what acts, from the hidden states."""
        ...

    def rests(self, path: Call) -> tuple[Sum, ...]:
        """Return the hidden states where nothing is remembered."""
        ...

    def fades(self, path: Call) -> float:
        """Return the time after which it does not matter where they began, if known."""
        ...

    def said(self, path: Call, sure: Sequence[str]) -> str:
        """Return what its numbers say to somebody who reads the report, and how sure each is."""
        ...

    def along(
        self, path: Call, rows: np.ndarray, starts: Sequence[float] | None = None
    ) -> np.ndarray:
        """Return the hidden states on rows of a record, shape (n_samples, order).

        They begin with given values on the first row, by default where nothing is remembered.
        """
        ...

    def spans(self, path: Call, rows: np.ndarray) -> list[tuple[float, float]]:
        """Return between which values each hidden state may begin on a record."""
        ...


UNSAID = ("", "")  # nothing after any number
KINDS: dict[Operator, PathKind] = {
    BOUC_WEN: Hysteresis(),
    WEN_SPRING: SpringHysteresis(),
    RELAXING: Relaxation(),
    FLEXIBLE_MODE: FlexibleMode(),
}


def kind_of(path: Call) -> PathKind:
    """Return of which kind a path is."""
    return KINDS[path.operator]


def source_of(path: Call) -> Sum:
    """Return the measured state that a path follows."""
    return path.args[0]


def paths_in(equations: Equations) -> tuple[Call, ...]:
    """Return the different paths that equations hold."""
    found: dict[Call, None] = {}
    for term, used in zip(equations.terms, np.any(equations.coef != 0.0, axis=0), strict=True):
        if used:
            found |= dict.fromkeys(a for a, _ in term.factors if _is_path(a))
    return tuple(found)


def paths_within(expressions: Sequence[Sum]) -> tuple[Call, ...]:
    """Return the different paths that expressions hold."""
    products = (product for expression in expressions for _, product in expression.parts)
    return tuple(dict.fromkeys(a for p in products for a, _ in p.factors if _is_path(a)))


def sayings(
    expressions: Sequence[Sum], names: Sequence[str], sure: Sequence[str] = ()
) -> list[str]:
    """Return what the numbers of the paths in expressions say, with the names of variables.

    `sure` is said after each number.
    """
    return [
        f"{source_of(path).name(names)}_{kind.suffix}: {kind.said(path, sure or UNSAID)}"
        for path, kind in ((path, kind_of(path)) for path in paths_within(expressions))
    ]


def _is_path(atom: object) -> TypeGuard[Call]:
    return isinstance(atom, Call) and atom.operator in KINDS


def hidden_along(
    paths: Sequence[Call], rows: np.ndarray, starts: Sequence[float] | None = None
) -> np.ndarray:
    """Return the hidden states of paths on rows of a record, shape (n_samples, n_hidden).

    They begin with given values on the first row, by default where nothing is remembered.
    """
    begun = [starts and own_states(starts, paths, path) for path in paths]
    along = (kind_of(path).along(path, rows, own) for path, own in zip(paths, begun, strict=True))
    return np.column_stack([rows[:, :0], *along])


def n_hidden_of(paths: Sequence[Call]) -> int:
    """Return how many hidden states paths have."""
    return sum(kind_of(path).order for path in paths)


def own_states(hidden: Sequence[Any], paths: Sequence[Call], path: Call) -> Sequence[Any]:
    """Return what of the hidden states of all paths belongs to one of them."""
    first = n_hidden_of(paths[: paths.index(path)])
    return hidden[first : first + kind_of(path).order]


def moved(path: Call, replacements: Mapping[int, Sum] | Mapping[int | Call, Sum]) -> Call:
    """Return a path with some of its variables replaced, and not itself."""
    return Call(path.operator, tuple(substituted(a, replacements) for a in path.args))


def path_rates(path: Call, states: Sequence[Sum]) -> list[Sum]:
    """Return the rates of the hidden states of a path, from these states."""
    kind = kind_of(path)
    parts = zip(kind.weights(path), kind.parts(path, states), strict=True)
    return [*states[1:], reduce(add, (mul(constant(weight), part) for weight, part in parts))]
