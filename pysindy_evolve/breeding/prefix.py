"""Converts terms to prefix trees, which crossover and mutation cut and join, and back.

In prefix order an operator comes before its arguments: q sgn(v) is mul, q, sgn, v. A node is an
operator, or a leaf: a sum that is one variable or one number.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ..operators import BUILTIN, Operator
from ..terms import Atom, Call, Product, Sum, Variable, call, constant, variable

Node = Operator | Sum  # of a tree
Memo = dict[tuple[Any, ...], Sum]

ADD, MUL, DIV = (BUILTIN[name] for name in ("add", "mul", "div"))


def to_prefix(term: Product) -> list[Node]:
    """Write a term as a prefix tree, with mul, div and add even if the search lacks them.

    Parameters
    ----------
    term : Product
        A term.

    Returns
    -------
    list of Operator or Sum
        Operators, each before its arguments, and leaves.
    """
    numerator = [node for atom, n in term.factors for node in [_of_atom(atom)] * max(n, 0)]
    denominator = [node for atom, n in term.factors for node in [_of_atom(atom)] * max(-n, 0)]
    top: list[Node] = _joined(MUL, numerator) if numerator else [constant(1.0)]
    return [DIV, *top, *_joined(MUL, denominator)] if denominator else top


def from_prefix(nodes: Sequence[Node], memo: Memo) -> Sum:
    """Read a prefix tree, in canonical form.

    Parameters
    ----------
    nodes : sequence of Operator or Sum
        Operators, each before its arguments, and leaves.
    memo : dict
        Branches that were read before; those of this tree are added.

    Returns
    -------
    Sum
        The terms of the tree with their coefficients.
    """
    stack: list[Sum] = []
    for node in reversed(nodes):
        if isinstance(node, Sum):
            stack.append(node)
            continue
        arguments = [stack.pop() for _ in range(node.arity)]
        key = (node.name, *arguments)
        if key not in memo:
            memo[key] = call(node, *arguments)
        stack.append(memo[key])
    return stack[0]


def _of_atom(atom: Atom) -> list[Node]:
    if isinstance(atom, Variable):
        return [variable(atom.index)]
    if isinstance(atom, Call):
        return [atom.operator, *(node for argument in atom.args for node in _of_sum(argument))]
    return _of_sum(atom)


def _of_sum(total: Sum) -> list[Node]:
    parts: list[list[Node]] = []
    for coefficient, term in total.parts:
        if not term.factors:
            parts.append([constant(coefficient)])
        elif coefficient == 1.0:
            parts.append(to_prefix(term))
        else:
            parts.append([MUL, constant(coefficient), *to_prefix(term)])
    return _joined(ADD, parts) if parts else [constant(0.0)]


def _joined(operator: Operator, pieces: list[list[Node]]) -> list[Node]:
    nodes = list(pieces[-1])
    for piece in reversed(pieces[:-1]):
        nodes = [operator, *piece, *nodes]
    return nodes
