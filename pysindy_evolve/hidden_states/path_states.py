"""Hidden states that follow the path of a measured state: the interface of all their kinds.

A path is a term with memory: an operator on the rows of a record in time order, whose first
argument is the measured state. Written out, it is a function of hidden states. The rate of the last
one is linear in some weights, so these can be fitted like coefficients:

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

from collections.abc import Iterable, Mapping, Sequence
from functools import reduce
from typing import Any, Protocol, TypeGuard

import numpy as np

from ..equations import Equations
from ..operators import Operator
from ..substitution import substituted
from ..terms import Call, Product, Sum, add, constant, mul
from .boucwen import BOUC_WEN, Hysteresis
from .flexible_mode import FLEXIBLE_MODE, FlexibleMode
from .relaxing import RELAXING, Relaxation
from .wen_spring import WEN_SPRING, SpringHysteresis


class PathKind(Protocol):
    """Methods that a model needs for the paths of one operator.

    A path has `order` hidden states, each the rate of the one before. Each is named after one of
    the first arguments of the operator, with `suffix` at the end.
    """

    suffix: str
    order: int

    def numbers(self, path: Call) -> tuple[float, ...]:
        """Return the numeric arguments of the operator."""
        ...

    def weights(self, path: Call) -> tuple[float, ...]:
        """Return the weights in the rate of the last hidden state."""
        ...

    def numbers_from(self, weights: np.ndarray) -> tuple[float, ...]:
        """Return the numeric arguments from the weights, the first of which is positive."""
        ...

    def parts(self, path: Call, states: Sequence[Sum]) -> tuple[Sum, ...]:
        """Return the expressions that the weights multiply in the rate of the last hidden state."""
        ...

    def term(self, path: Call, states: Sequence[Sum]) -> Sum:
        """Return the value of the path as an expression of the hidden states."""
        ...

    def rests(self, path: Call) -> tuple[Sum, ...]:
        """Return the hidden states in balance, as expressions of the arguments of the path."""
        ...

    def fades(self, path: Call) -> float:
        """Return the time after which the initial states no longer matter; 0 if it is not known."""
        ...

    def describe(self, path: Call, sure: Sequence[str]) -> str:
        """Return the numbers in words for the report; `sure` holds the interval of each as text."""
        ...

    def along(
        self, path: Call, rows: np.ndarray, starts: Sequence[float] | None = None
    ) -> np.ndarray:
        """Return the hidden states on rows of a record, shape (n_samples, order).

        `starts` are their values on the first row; by default they are in balance there.
        """
        ...

    def spans(self, path: Call, rows: np.ndarray) -> list[tuple[float, float]]:
        """Return the lowest and the highest value of each hidden state on the first row."""
        ...


NO_INTERVALS = ("", "")  # empty texts after the two numbers of a path
KINDS: dict[Operator, PathKind] = {
    BOUC_WEN: Hysteresis(),
    WEN_SPRING: SpringHysteresis(),
    RELAXING: Relaxation(),
    FLEXIBLE_MODE: FlexibleMode(),
}


def kind_of(path: Call) -> PathKind:
    """Return the kind of a path."""
    return KINDS[path.operator]


def source_of(path: Call) -> Sum:
    """Return the measured state that a path follows."""
    return path.args[0]


def paths_in(equations: Equations) -> tuple[Call, ...]:
    """Return the distinct paths in equations, of terms whose coefficient is not zero."""
    return _distinct_paths(equations.terms[i] for i in equations.used)


def paths_within(expressions: Sequence[Sum]) -> tuple[Call, ...]:
    """Return the distinct paths in expressions."""
    return _distinct_paths(term for expression in expressions for _, term in expression.parts)


def _distinct_paths(products: Iterable[Product]) -> tuple[Call, ...]:
    return tuple(dict.fromkeys(a for p in products for a, _ in p.factors if _is_path(a)))


def path_sentences(
    expressions: Sequence[Sum], names: Sequence[str], sure: Sequence[str] = ()
) -> list[str]:
    """Return a sentence on the numbers of each path in expressions, with the names of variables.

    `sure` holds the text that follows each number, such as its interval.
    """
    return [
        f"{source_of(path).name(names)}_{kind.suffix}: {kind.describe(path, sure or NO_INTERVALS)}"
        for path, kind in ((path, kind_of(path)) for path in paths_within(expressions))
    ]


def _is_path(atom: object) -> TypeGuard[Call]:
    return isinstance(atom, Call) and atom.operator in KINDS


def hidden_along(
    paths: Sequence[Call], rows: np.ndarray, starts: Sequence[float] | None = None
) -> np.ndarray:
    """Return the hidden states of paths on rows of a record, shape (n_samples, n_hidden).

    `starts` are their values on the first row; by default they are in balance there.
    """
    given = [starts and own_states(starts, paths, path) for path in paths]
    along = (kind_of(path).along(path, rows, own) for path, own in zip(paths, given, strict=True))
    return np.column_stack([rows[:, :0], *along])


def n_hidden_of(paths: Sequence[Call]) -> int:
    """Return the number of hidden states of paths."""
    return sum(kind_of(path).order for path in paths)


def own_states(hidden: Sequence[Any], paths: Sequence[Call], path: Call) -> Sequence[Any]:
    """Return the hidden states of one path out of those of all paths."""
    first = n_hidden_of(paths[: paths.index(path)])
    return hidden[first : first + kind_of(path).order]


def with_replaced_arguments(
    path: Call, replacements: Mapping[int, Sum] | Mapping[int | Call, Sum]
) -> Call:
    """Return a path with variables replaced in its arguments; the path itself is not replaced."""
    return Call(path.operator, tuple(substituted(a, replacements) for a in path.args))


def path_rates(path: Call, states: Sequence[Sum]) -> list[Sum]:
    """Return the rates of the hidden states of a path as expressions of these states."""
    kind = kind_of(path)
    parts = zip(kind.weights(path), kind.parts(path, states), strict=True)
    return [*states[1:], reduce(add, (mul(constant(weight), part) for weight, part in parts))]
