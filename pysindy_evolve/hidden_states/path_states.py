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
======================  ==================================  ======================  ==========
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import reduce
from typing import Protocol, TypeGuard

import numpy as np

from ..equations import Equations
from ..operators import Operator
from ..substitution import substituted
from ..terms import Call, Sum, add, constant, mul
from .boucwen import BOUC_WEN, Hysteresis
from .relaxing import RELAXING, Relaxation
from .wen_spring import WEN_SPRING, SpringHysteresis

__all__ = ["PathKind", "kind_of", "moved", "path_rate", "paths_in", "sayings", "source_of"]


class PathKind(Protocol):
    """What a model needs to know of the terms of one operator, its paths.

    `suffix` is what the name of the hidden state ends in, after that of the measured one.
    """

    suffix: str

    def numbers(self, path: Call) -> tuple[float, ...]:
        """Return the numbers that the operator is given."""
        ...

    def weights(self, path: Call) -> tuple[float, ...]:
        """Return the weights in the rate of the hidden state."""
        ...

    def numbers_from(self, weights: np.ndarray) -> tuple[float, ...]:
        """Return the numbers from weights, the first of which is positive."""
        ...

    def parts(self, path: Call, state: Sum) -> tuple[Sum, ...]:
        """Return what the weights multiply in the rate of the hidden state."""
        ...

    def term(self, path: Call, state: Sum) -> Sum:
        """Return what acts, from the hidden state."""
        ...

    def rest(self, path: Call) -> Sum:
        """Return the hidden state where nothing is remembered."""
        ...

    def fades(self, path: Call) -> float:
        """Return the time after which it does not matter where the hidden state began, if known."""
        ...

    def said(self, path: Call, sure: Sequence[str]) -> str:
        """Return what its numbers say to somebody who reads the report, and how sure each is."""
        ...

    def along(self, path: Call, rows: np.ndarray, start: float | None = None) -> np.ndarray:
        """Return the hidden state on rows of a record, from its value on the first one."""
        ...

    def span(self, path: Call, rows: np.ndarray) -> tuple[float, float]:
        """Return between which values the hidden state may begin on a record."""
        ...


UNSAID = ("", "")  # nothing after any number
KINDS: dict[Operator, PathKind] = {
    BOUC_WEN: Hysteresis(),
    WEN_SPRING: SpringHysteresis(),
    RELAXING: Relaxation(),
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


def sayings(
    expressions: Sequence[Sum], names: Sequence[str], sure: Sequence[str] = ()
) -> list[str]:
    """Return what the numbers of the paths in expressions say, with the names of variables.

    `sure` is said after each number.
    """
    products = (product for expression in expressions for _, product in expression.parts)
    paths = dict.fromkeys(a for product in products for a, _ in product.factors if _is_path(a))
    return [
        f"{source_of(path).name(names)}_{kind.suffix}: {kind.said(path, sure or UNSAID)}"
        for path, kind in ((path, kind_of(path)) for path in paths)
    ]


def _is_path(atom: object) -> TypeGuard[Call]:
    return isinstance(atom, Call) and atom.operator in KINDS


def moved(path: Call, replacements: Mapping[int, Sum] | Mapping[int | Call, Sum]) -> Call:
    """Return a path with some of its variables replaced, and not itself."""
    return Call(path.operator, tuple(substituted(a, replacements) for a in path.args))


def path_rate(path: Call, state: Sum) -> Sum:
    """Return the rate of the hidden state of a path, from that state."""
    kind = kind_of(path)
    parts = zip(kind.weights(path), kind.parts(path, state), strict=True)
    return reduce(add, (mul(constant(weight), part) for weight, part in parts))
