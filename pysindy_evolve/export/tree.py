"""An equation as a tree of sums, products and calls."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from ..terms import ONE, Atom, Call, Product, Sum, Variable
from .printing import format_number
from .symbolic import System, constant_last


@dataclass(frozen=True)
class Node:
    """One node of the tree.

    Parameters
    ----------
    label : str
        Text of the node.
    kind : {"left", "operator", "function", "coefficient", "constant", "variable"}
        What it stands for; "left" is the left-hand side at the root.
    children : tuple of Node
        Its operands.
    """

    label: str
    kind: str
    children: tuple[Node, ...] = ()

    @cached_property
    def size(self) -> int:
        """Number of nodes."""
        return 1 + sum(child.size for child in self.children)

    @cached_property
    def depth(self) -> int:
        """Levels below this one."""
        return 1 + max((child.depth for child in self.children), default=-1)


def expression_tree(system: System, index: int, digits: int | None = 4) -> Node:
    """Return the tree of one equation, the constant term last.

    Parameters
    ----------
    system : System
        Collected equations.
    index : int
        Which equation.
    digits : int or None
        Significant digits of the numbers.

    Returns
    -------
    Node
    """
    return _sum(system.sides[index], system.names, digits, "coefficient")


def _sum(side: Sum, names: tuple[str, ...], digits: int | None, kind: str) -> Node:
    children = tuple(_part(c, term, names, digits, kind) for c, term in constant_last(side))
    if not children:
        return Node("0", "constant")
    return children[0] if len(children) == 1 else Node("+", "operator", children)


def _part(
    coefficient: float, term: Product, names: tuple[str, ...], digits: int | None, kind: str
) -> Node:
    if term == ONE:
        return Node(_number(coefficient, digits), "constant")
    node = _product(term, names, digits)
    if coefficient == 1.0:
        return node
    label = "−" if coefficient == -1.0 else _number(coefficient, digits)
    return Node(label, kind, (node,))


def _product(term: Product, names: tuple[str, ...], digits: int | None) -> Node:
    numerator = tuple(_factor(a, n, names, digits) for a, n in term.factors if n > 0)
    denominator = tuple(_factor(a, -n, names, digits) for a, n in term.factors if n < 0)
    top = _times(numerator) if numerator else Node("1", "constant")
    return Node("÷", "operator", (top, _times(denominator))) if denominator else top


def _times(factors: tuple[Node, ...]) -> Node:
    return factors[0] if len(factors) == 1 else Node("×", "operator", factors)


def _factor(atom: Atom, exponent: int, names: tuple[str, ...], digits: int | None) -> Node:
    raised = "" if exponent == 1 else str(exponent).translate(_SUPERSCRIPTS)
    if isinstance(atom, Variable):
        return Node(names[atom.index] + raised, "variable")
    if isinstance(atom, Call):
        arguments = tuple(_sum(a, names, digits, "constant") for a in atom.args)
        return Node(atom.operator.name + raised, "function", arguments)
    inner = _sum(atom, names, digits, "constant")
    return inner if not raised else Node(f"( ){raised}", "operator", (inner,))


_SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def _number(value: float, digits: int | None) -> str:
    mantissa, _, exponent = format_number(value, digits).replace("-", "−").partition("e")
    if not exponent:
        return mantissa
    power = f"10{exponent.replace('−', '-').translate(_SUPERSCRIPTS)}"
    return mantissa.removesuffix("1") + power if mantissa in ("1", "−1") else f"{mantissa}·{power}"
