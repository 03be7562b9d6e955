"""Random terms, crossover and mutation; the only file that imports DEAP.

Individuals are terms. DEAP varies each as a prefix tree. The result is brought to canonical form
and split at its sums: every product is an individual, so an addition never mixes a good term with
a bad one. Trees are never compiled or evaluated as text.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Iterable, Sequence
from functools import lru_cache
from types import FunctionType
from typing import Any

import numpy as np
from deap import gp

from ..operators import BUILTIN, CURVED, Operator
from ..terms import Atom, Call, Product, Sum, constant, simplified, variable
from .prefix import Memo, from_prefix, to_prefix

MAX_SPLIT = 6  # terms; a tree that splits into more is dropped
NODES_PER_LEVEL = 4  # nodes that a term may have for each level of `max_depth`
TOURNAMENT = 3  # terms in a tournament, as usual in genetic programming: mild selection pressure
# Operators that hardly need inner constants; a search with any other one is called smooth.
LINEAR = ("add", "sub", "mul", "neg", "square", "cube", "abs", "sgn")


class Genetics:
    """Variation of terms, drawing from one generator.

    Parameters
    ----------
    operators : sequence of Operator
        Basis functions.
    scale : ndarray of shape (n_variables,)
        Typical size of each variable, in its own unit. Inner constants are drawn around it and
        its inverse, where x/(c + x) and sin(w x) need them.
    max_depth : int
        Height of the tallest tree.
    rng : numpy.random.Generator
        Source of all randomness.
    """

    def __init__(
        self,
        operators: Sequence[Operator],
        scale: np.ndarray,
        *,
        max_depth: int,
        rng: np.random.Generator,
    ) -> None:
        self.random = random.Random(int(rng.integers(2**62)))
        self.max_depth = max_depth
        self._operators = {operator.name: operator for operator in operators}
        self._known = {**BUILTIN, **self._operators}  # `_tree` adds those of parents
        self._arities = {0, *(operator.arity for operator in operators)}
        self._scale = [float(size) for size in scale]
        self.smooth = any(name not in LINEAR for name in self._operators)
        self._curves = any(name in CURVED for name in self._operators)
        self._deap = _deap_drawing_from(self.random)
        self._pset = self._primitive_set()
        self._memo: Memo = {}

    def random_terms(self, n: int, known: Iterable[Product] = ()) -> list[Product]:
        """Return up to `n` random terms, all different and none of them known."""
        return self._gather(n, set(known), self._random_child)

    def offspring(
        self,
        parents: Sequence[Product],
        fitness: Sequence[float] | np.ndarray,
        n: int,
        *,
        crossover_rate: float,
        mutation_rate: float,
    ) -> list[Product]:
        """Breed up to `n` new terms.

        Parameters
        ----------
        parents : sequence of Product
            Terms to choose from, by tournament.
        fitness : sequence of float
            Lower is better.
        n : int
            Number of children.
        crossover_rate, mutation_rate : float
            Probabilities in [0, 1].

        Returns
        -------
        list of Product
            All different, none of them a parent. A child that is not new is mutated; if that does
            not help, another one is bred, and in the end random terms fill up the number.
        """

        def child() -> list[Product]:
            tree = self._select(parents, fitness)
            if self.random.random() < crossover_rate:
                tree = self._crossed(tree, self._select(parents, fitness))
            terms = self._terms(tree)
            if self.random.random() < mutation_rate or known.issuperset(terms):
                terms = self._terms(self._mutated(tree))
            return terms

        known = set(parents)
        children = self._gather(n, known, child)
        return children + self._gather(n - len(children), known, self._random_child)

    def _gather(
        self, n: int, known: set[Product], make: Callable[[], list[Product]]
    ) -> list[Product]:
        found: list[Product] = []
        for _ in range(4 * n):  # bounded, as a small space of terms may not hold n new ones
            if len(found) >= n:
                break
            for term in make():
                if term not in known:
                    known.add(term)
                    found.append(term)
        return found[:n]

    def _select(
        self, parents: Sequence[Product], fitness: Sequence[float] | np.ndarray
    ) -> gp.PrimitiveTree:
        rivals = [self.random.randrange(len(parents)) for _ in range(TOURNAMENT)]
        return self._tree(parents[min(rivals, key=lambda i: fitness[i])])

    def _tree(self, term: Product) -> gp.PrimitiveTree:
        nodes = _prefix(term)
        for node in nodes:
            if isinstance(node, Operator):
                self._known.setdefault(node.name, node)
        return gp.PrimitiveTree(map(_node, nodes))

    def _random_child(self) -> list[Product]:
        nodes = self._deap["genHalfAndHalf"](self._pset, 1, min(self.max_depth, 3))
        return self._terms(gp.PrimitiveTree(nodes))

    def _crossed(self, one: gp.PrimitiveTree, other: gp.PrimitiveTree) -> gp.PrimitiveTree:
        """Exchange a subtree, or join both trees: DEAP cannot cross a tree of one node."""
        if min(len(one), len(other)) < 2 or self.random.random() < 0.5:
            joint = self.random.choice(self._binary) if self._binary else None
            return gp.PrimitiveTree([joint, *one, *other]) if joint else one
        return self.random.choice(self._deap["cxOnePoint"](one, other))

    def _mutated(self, tree: gp.PrimitiveTree) -> gp.PrimitiveTree:
        moves = ["mutUniform", "mutInsert", "mutShrink"]
        if {node.arity for node in tree} <= self._arities:  # it needs a substitute for every node
            moves.append("mutNodeReplacement")
        if self.smooth:
            moves += ["number"] * 2
        move = self.random.choice(moves)
        if move == "number":
            return self._with_number(tree)
        if move == "mutUniform":
            return self._deap[move](tree, self._short_branch, self._pset)[0]
        if move == "mutShrink":
            return self._deap[move](tree)[0]
        return self._deap[move](tree, self._pset)[0]

    def _with_number(self, tree: gp.PrimitiveTree) -> gp.PrimitiveTree:
        """Put a number beside a variable: q becomes c + q or c q."""
        leaves = [i for i, node in enumerate(tree) if not node.arity and node.value.variables]
        if leaves:
            i, joint = self.random.choice(leaves), self.random.choice((_ADD, _MUL))
            number = _terminal(constant(self._number()))
            tree[i : i + 1] = gp.PrimitiveTree([joint, number, tree[i]])
        return tree

    def _short_branch(self, pset: Any, type_: Any) -> list[Any]:
        return self._deap["genHalfAndHalf"](pset, 0, 2, type_)

    def _terms(self, tree: gp.PrimitiveTree) -> list[Product]:
        if tree.height > 2 * self.max_depth:
            return []
        parts = self._expression(tree).parts
        if len(parts) > MAX_SPLIT:
            return []
        return [term for _, term in map(_signs_above, parts) if self._fits(term)]

    def _fits(self, term: Product) -> bool:
        small = term.size <= NODES_PER_LEVEL * self.max_depth and term.depth <= self.max_depth
        if not small or not term.variables or (self._curves and _is_nested(term)):
            return False
        return not any(map(is_even_power_of_sgn, term.factors))

    def _expression(self, tree: gp.PrimitiveTree) -> Sum:
        return from_prefix([self._meaning(node) for node in tree], self._memo)

    def _meaning(self, node: gp.Primitive | gp.Terminal) -> Operator | Sum:
        if not node.arity:
            return node.value
        return self._known[node.name]

    def _primitive_set(self) -> gp.PrimitiveSet:
        pset = gp.PrimitiveSet("terms", 0)
        for operator in self._operators.values():
            pset.addPrimitive(operator.function, operator.arity, name=operator.name)
        self._binary = [_primitive(o) for n, o in self._operators.items() if n in ("mul", "div")]
        n_variables = len(self._scale)
        leaves = [variable(i) for i in range(n_variables) for _ in range(2)]
        n_numbers = n_variables if self.smooth else 1
        leaves += [constant(self._number()) for _ in range(n_numbers)]
        pset.terminals[gp.__type__].extend(_terminal(leaf) for leaf in leaves)
        return pset

    def _number(self) -> float:
        size = self.random.choice(self._scale) ** self.random.choice((1, -1))
        return float(f"{size * self.random.lognormvariate(0, 1):.3g}")


def _signs_above(part: tuple[float, Product]) -> tuple[float, Product]:
    """Write q sgn(v) for q/sgn(v): equal except at v = 0, where only the product has a value."""
    coefficient, term = part
    divides_by_sign = any(n < 0 and _is_sign(atom) for atom, n in term.factors)
    if not divides_by_sign:
        return part
    factors = tuple((atom, abs(n) if _is_sign(atom) else n) for atom, n in term.factors)
    return coefficient, simplified(factors)


def _is_sign(atom: Atom) -> bool:
    return isinstance(atom, Call) and atom.operator == BUILTIN["sgn"]


def is_even_power_of_sgn(factor: tuple[Atom, int]) -> bool:
    """Tell whether a factor is sgn(v)^2 or like it: 1 except at v = 0, it hides single samples."""
    atom, n = factor
    return _is_sign(atom) and n % 2 == 0


def _is_nested(node: Product | Atom, inside: bool = False) -> bool:
    """Tell whether a function in `CURVED` is in the argument of another one.

    Such terms fit any record and explain nothing: sin(sin(q)) is no law of nature.
    """
    curved = isinstance(node, Call) and node.operator.name in CURVED
    return (inside and curved) or any(_is_nested(one, inside or curved) for one in node.children)


def _deap_drawing_from(source: random.Random) -> dict[str, Any]:
    """Return copies of DEAP's operators that draw from `source` instead of the global `random`.

    The operators look `random` up in the globals of their module. With other globals they leave
    the caller's stream alone, and two threads do not disturb each other; seeding the global
    generator could not ensure this.
    """
    namespace = dict(vars(gp))
    for name, value in vars(gp).items():
        if isinstance(value, FunctionType) and value.__module__ == gp.__name__:
            copy = FunctionType(
                value.__code__, namespace, name, value.__defaults__, value.__closure__
            )
            namespace[name] = copy
    namespace["random"] = source
    return namespace


@lru_cache(256)
def _primitive(operator: Operator) -> gp.Primitive:
    return gp.Primitive(operator.name, [gp.__type__] * operator.arity, gp.__type__)


@lru_cache(1024)
def _terminal(value: Sum) -> gp.Terminal:
    return gp.Terminal(value, False, gp.__type__)


_ADD, _MUL = (_primitive(BUILTIN[name]) for name in ("add", "mul"))


@lru_cache(4096)  # a good term is a parent many times over
def _prefix(term: Product) -> tuple[Operator | Sum, ...]:
    return tuple(to_prefix(term))


def _node(node: Operator | Sum) -> gp.Primitive | gp.Terminal:
    return _primitive(node) if isinstance(node, Operator) else _terminal(node)
