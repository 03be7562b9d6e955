"""Evaluate the terms of a structure on many columns at once, with the signs as arguments.

A tape is a list of instructions over numpy arrays, each distinct subtree once. It needs no
compilation, so that every candidate of a search can be simulated. Operators are called in their
numpy form.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..operators import BUILTIN
from ..terms import ONE, Atom, Call, Product, Sum, Variable
from .structure import Switch


class Instruction(NamedTuple):
    """One array operation: function(*values of the arguments) goes to a register."""

    register: int
    function: Callable[..., Any]
    arguments: tuple[int, ...]


class Tape:
    """Instructions for the terms of some equations and for the arguments of their switches.

    Parameters
    ----------
    terms : sequence of Product
        Columns of the dictionary, with their true inner constants.
    switches : sequence of Switch
        Arguments of sgn in these terms.
    n_variables : int
        States, inputs and time.
    """

    def __init__(
        self, terms: Sequence[Product], switches: Sequence[Switch], n_variables: int
    ) -> None:
        self._signs = {switch.g: n_variables + i for i, switch in enumerate(switches)}
        self._n_given = n_variables + len(switches)
        self._nested = 0  # number of functions around the atom that is being recorded
        self._known: dict[Any, int] = {}
        # After variables and signs: a constant, or None for what an instruction fills in.
        self._blank: list[np.ndarray | None] = []
        self._instructions: list[Instruction] = []
        self._g = [self._sum(switch.g) for switch in switches]
        self._for_g = tuple(self._instructions)
        self._theta = [self._product(term) for term in terms]

    def theta(self, variables: Sequence[np.ndarray], signs: Any) -> np.ndarray:
        """Return the terms, shape (n_terms, n_columns)."""
        return self._run(self._instructions, self._theta, variables, signs)

    def switches(self, variables: Sequence[np.ndarray], signs: Any) -> np.ndarray:
        """Return the arguments of the signs, shape (n_switches, n_columns)."""
        return self._run(self._for_g, self._g, variables, signs)

    def _run(
        self,
        instructions: Sequence[Instruction],
        wanted: Sequence[int],
        variables: Sequence[np.ndarray],
        signs: Any,
    ) -> np.ndarray:
        values: list[Any] = [*variables, *signs, *self._blank]
        for register, function, arguments in instructions:
            if len(arguments) == 2:  # most are, and this is the innermost loop of all runs
                first, second = arguments
                values[register] = function(values[first], values[second])
            else:
                values[register] = function(*[values[i] for i in arguments])
        out = np.empty((len(wanted), len(variables[0])))
        for row, register in enumerate(wanted):
            out[row] = values[register]
        return out

    def _emit(self, function: Callable[..., Any], *arguments: int) -> int:
        key = (function, arguments)
        if key not in self._known:
            self._known[key] = self._register(None)
            self._instructions.append(Instruction(self._known[key], function, arguments))
        return self._known[key]

    def _constant(self, value: float) -> int:
        if value not in self._known:
            # numpy takes an array of no dimension faster than a number.
            self._known[value] = self._register(np.array(value))
        return self._known[value]

    def _register(self, content: np.ndarray | None) -> int:
        self._blank.append(content)
        return self._n_given + len(self._blank) - 1

    def _sum(self, expression: Sum) -> int:
        total: int | None = None
        for coefficient, term in expression.parts:
            part = self._product(term)
            if term == ONE:
                part = self._constant(coefficient)
            elif coefficient != 1.0:
                part = self._emit(np.multiply, self._constant(coefficient), part)
            total = part if total is None else self._emit(np.add, total, part)
        return self._constant(0.0) if total is None else total

    def _product(self, term: Product) -> int:
        result: int | None = None
        for atom, exponent in term.factors:
            base = self._atom(atom)
            factor = base
            for _ in range(abs(exponent) - 1):
                factor = self._emit(np.multiply, factor, base)
            if exponent < 0:
                factor = self._emit(np.divide, self._constant(1.0), factor)
            result = factor if result is None else self._emit(np.multiply, result, factor)
        return self._constant(1.0) if result is None else result

    def _atom(self, atom: Atom) -> int:
        if isinstance(atom, Variable):
            return atom.index
        if isinstance(atom, Sum):
            return self._sum(atom)
        return self._call(atom)

    def _call(self, atom: Call) -> int:
        if atom.operator == BUILTIN["sgn"]:
            return self._signs[atom.args[0]]
        if atom.operator == BUILTIN["abs"] and atom.args[0] in self._signs and not self._nested:
            return self._emit(np.multiply, self._signs[atom.args[0]], self._sum(atom.args[0]))
        self._nested += 1
        arguments = [self._sum(argument) for argument in atom.args]
        self._nested -= 1
        return self._emit(atom.operator.function, *arguments)
