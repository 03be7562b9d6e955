"""Where forces enter: through an inverse mass matrix, a torque at one joint moves them all.

In the acceleration of a cart with a pendulum, a force F enters as F / (M + m sin(theta)^2), and so
does friction at the cart. So the factor of an input, or of the velocity of a declared damping, is
the factor of any force at that place.
"""

from __future__ import annotations

from dataclasses import dataclass

from ...operators import BUILTIN
from ...terms import Call, Product, Sum, Variable, div, mul, of_term, variable
from ..given.design import Design
from .candidate import bare

AS_INPUT = "as if"  # how the text for a coefficient that adds to an input begins


@dataclass(frozen=True)
class Entry:
    """How forces enter an equation at one place, and the velocities that they may depend on.

    The place is that of `beside`: an input, or the velocity that a declared damping acts on. Where
    the factor of an input `is_known`, another force there adds to the input itself.
    """

    factor: Sum
    velocities: tuple[int, ...]
    beside: int
    is_known: bool = False


def entries_of(design: Design, state: int) -> list[Entry]:
    """Return the places where forces enter one equation with a factor that is not constant.

    Parameters
    ----------
    design : Design
        The model so far.
    state : int
        The equation.

    Returns
    -------
    list of Entry
        With the velocity that a declared damping gives for the place; without one, all of them. A
        load that presses on a brake, as N sgn(v), is no such place.
    """
    sides = [column.parts[state] for column in design.columns if column.parts[state].parts]
    found: dict[Sum, Entry] = {}
    for velocity in design.velocities:
        for side in sides:
            factor = _factor_of(side, velocity)
            if len(factor.parts) == len(side.parts):
                found.setdefault(bare(factor), Entry(factor, (velocity,), velocity))
    first = len(design.states)
    for column in range(first, first + len(design.inputs)):
        for side in (design.fixed[state], *sides):
            factor = _factor_of(side, column)
            if factor.parts:
                known = found.get(bare(factor))
                where = design.velocities if known is None else known.velocities
                found[bare(factor)] = Entry(factor, where, column, side is design.fixed[state])
    return [one for one in found.values() if one.factor.variables and not _has_sign(one.factor)]


def entered(design: Design, state: int, expression: Sum) -> tuple[Entry, Sum] | None:
    """Return where an effect enters its equation, and which force it is there.

    Parameters
    ----------
    design : Design
        The model without the effect.
    state : int
        The equation.
    expression : Sum
        The effect.

    Returns
    -------
    Entry and Sum, or None
        The effect is the entry's factor times the force, the smallest of several; None if no
        declared force has such a factor.
    """
    first = expression.parts[0][1]
    found = [
        (entry, force)
        for entry in entries_of(design, state)
        for force in (_over(first, term) for _, term in entry.factor.parts)
        if bare(mul(entry.factor, force)) == bare(expression) and force.size < expression.size
    ]
    return min(found, key=lambda pair: pair[1].size, default=None)


def _has_sign(factor: Sum) -> bool:
    atoms = (atom for _, term in factor.parts for atom, _ in term.factors)
    return any(isinstance(atom, Call) and atom.operator == BUILTIN["sgn"] for atom in atoms)


def _over(term: Product, other: Product) -> Sum:
    """Divide a term by another; sums stay single factors, so that they cancel."""
    inverse = Product(tuple((atom, -n) for atom, n in other.factors))
    return mul(of_term(term), of_term(inverse))


def _factor_of(side: Sum, index: int) -> Sum:
    """Return the factor of a variable in the terms of an expression that are linear in it."""
    linear = tuple(
        (c, term)
        for c, term in side.parts
        if (Variable(index), 1) in term.factors
        and not any(index in atom.variables for atom, _ in term.factors if atom != Variable(index))
    )
    return div(Sum(linear), variable(index)) if linear else Sum(())
