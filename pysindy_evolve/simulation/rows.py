"""The rows f of x_dot = f and the switching functions g of a structure, as sympy expressions.

======  ==================  ==================================================================
symbol  shape               meaning
======  ==================  ==================================================================
h, t    ()                  step and time at its start
x       (n_states,)         states at the start of the step
u, du   (n_inputs,)         inputs at the start, and their slopes (linear between samples)
s       (n_switches,)       frozen values of the signs
w       (n_states,)         weights of the error estimate, 1/(tolerance * size of the state)
p       (n_parameters,)     coefficients and inner constants
======  ==================  ==================================================================
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import sympy

from ..operators import BUILTIN
from ..terms import ONE, Atom, Product, Sum, Variable
from .scalars import LOG, ROOT, Namespace, symbol, symbols
from .structure import FIRST_MARK, FREE, Structure


class Rows:
    """The right-hand sides of a structure over the symbols h, t, x, u, du, s, w and p.

    Parameters
    ----------
    structure : Structure
        Terms and switches.

    Attributes
    ----------
    f : list of expressions
        x_dot of each state.
    parts : list of list of expressions
        The terms of each row of f, with their coefficients.
    g : list of expressions
        Argument of each switch.
    namespace : Namespace
        Numbers and functions that the expressions name.
    """

    def __init__(self, structure: Structure) -> None:
        self.structure = structure
        self.namespace = Namespace()
        self._nested = 0  # number of functions around the atom that is being translated
        self._symbols()
        self._build()

    def slope(self, i: int, rates: Sequence[Any]) -> Any:
        """Return dg_i/dt along some rates, with the inner signs of g_i frozen."""
        g = self.g[i]
        moving = [*zip(self.x, rates, strict=True), *zip(self.u, self.du, strict=True)]
        moving.append((self.t, sympy.Integer(1)))
        if g.atoms(sympy.core.function.AppliedUndef):
            step = self.namespace.number(1e-6) * self.h
            return (g.xreplace({a: a + step * rate for a, rate in moving}) - g) / step
        return sympy.Add(*(sympy.diff(g, a) * rate for a, rate in moving if g.has(a)))

    def _symbols(self) -> None:
        structure = self.structure
        self.h, self.t = symbol("h"), symbol("t")
        self.x = symbols("x", structure.n_states)
        self.u = symbols("u", structure.n_inputs)
        self.du = symbols("du", structure.n_inputs)
        self.s = symbols("s", len(structure.switches))
        self.w = symbols("w", structure.n_states)
        n_free = sum(kind == FREE for row in structure.entries for _, kind in row)
        marks = [c for term in structure.terms for c in term.constants]
        n_constants = int(max(marks) - FIRST_MARK) + 1 if marks else 0
        self.p = symbols("p", n_free + n_constants)
        self._constants = self.p[n_free:]

    def _build(self) -> None:
        """Translate the rows f and the switching functions g to sympy."""
        structure = self.structure
        self._sign_of = {switch.g: s for switch, s in zip(structure.switches, self.s, strict=True)}
        self.g = [self._sum(switch.g) for switch in structure.switches]
        columns = [self._product(term) for term in structure.terms]
        free = iter(self.p)
        self.parts = [
            [(next(free) if kind == FREE else kind) * columns[i] for i, kind in row]
            for row in structure.entries
        ]
        self.f = [sympy.Add(*parts) for parts in self.parts]

    def _product(self, term: Product) -> Any:
        return sympy.Mul(*(self._atom(atom) ** n for atom, n in term.factors))

    def _sum(self, expression: Sum) -> Any:
        parts = []
        for coefficient, term in expression.parts:
            plain = abs(coefficient) == 1.0 and term != ONE
            index = int(coefficient - FIRST_MARK)
            factor = sympy.Integer(int(coefficient)) if plain else self._constants[index]
            parts.append(factor * self._product(term))
        return sympy.Add(*parts)

    def _atom(self, atom: Atom) -> Any:
        if isinstance(atom, Variable):
            return [*self.x, *self.u, self.t][atom.index]
        if isinstance(atom, Sum):
            return self._sum(atom)
        if atom.operator == BUILTIN["sgn"]:
            return self._sign_of[atom.args[0]]
        if atom.operator == BUILTIN["abs"] and atom.args[0] in self._sign_of:
            argument = self._sum(atom.args[0])
            if self._nested:  # a root or logarithm has no value on the continuation below zero
                return sympy.Abs(argument)
            return self._sign_of[atom.args[0]] * argument  # no kink within a step
        self._nested += 1
        arguments = [self._sum(argument) for argument in atom.args]
        self._nested -= 1
        if atom.operator == BUILTIN["sqrt"]:
            return ROOT(*arguments)  # as a power it would turn complex below zero
        if atom.operator == BUILTIN["log"]:
            return LOG(*arguments)
        if BUILTIN.get(atom.operator.name) == atom.operator:
            return atom.operator.to_sympy(*arguments)
        return self.namespace.function(atom.operator)(*arguments)
