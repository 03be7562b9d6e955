"""A model with free coefficients: known parts, and columns that enter linearly.

======  ============================  ========================================================
symbol  shape                         meaning
======  ============================  ========================================================
fixed   (n_states,) of Sum            known part of each right-hand side
column  (n_states,) of Sum            what one free coefficient multiplies in each of them
coef    (n_columns,)                  the free coefficients
======  ============================  ========================================================

A parameter that stands in several equations is one column with several parts.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ...equations import AlgebraicEquations, Equations
from ...hidden_states.path_states import paths_in
from ...terms import Cache, Call, Product, Sum
from .inertia import InertiaWave, over_inertia
from .kinematics import whole_state


@dataclass(frozen=True)
class Column:
    """What one free coefficient multiplies, in the equation of each state.

    Attributes
    ----------
    name : str
        Of the coefficient, or of the effect that it belongs to.
    parts : tuple of Sum, one for each state
        Expressions of the variables: states, inputs, time. Empty where it does not enter.
    inertia : InertiaWave, optional
        Wave whose amplitude is the coefficient. The part is then linearized: what the last fitted
        model lacks of the wave. `Design.equations` holds the exact form.
    """

    name: str
    parts: tuple[Sum, ...]
    inertia: InertiaWave | None = field(default=None, kw_only=True)

    def values_in(
        self, state: int, variables: np.ndarray, cache: Cache | None = None
    ) -> np.ndarray | None:
        """Return the values in one equation, shape (n_samples,); None if it does not enter it."""
        part = self.parts[state]
        return part.evaluate(variables, cache) if part.parts else None

    def evaluate(self, variables: np.ndarray, cache: Cache | None = None) -> np.ndarray:
        """Return the values in each equation, shape (n_samples, n_states)."""
        zero = np.zeros(len(variables))
        values = (self.values_in(state, variables, cache) for state in range(len(self.parts)))
        return np.column_stack([zero if value is None else value for value in values])

    @property
    def size(self) -> int:
        """Number of nodes of its expressions."""
        return sum(part.size for part in self.parts if part.parts)


def in_state(name: str, expression: Sum, state: int, n_states: int) -> Column:
    """Return the column that enters the equation of one state only."""
    parts = [Sum(())] * n_states
    parts[state] = expression
    return Column(name, tuple(parts))


@dataclass(frozen=True)
class Design:
    """A model whose right-hand sides are known parts plus columns times coefficients.

    Attributes
    ----------
    states, inputs : tuple of str
        Names, in the order of the columns of x and u.
    fixed : tuple of Sum, one for each state
        Known part of each right-hand side, units of x_dot.
    columns : tuple of Column
        What the free coefficients multiply, one for each of them.
    algebraic : bool
        Whether the right-hand sides are the states themselves, not their rates.
    motions : tuple of (int, int)
        Variables that are position and velocity to each other, in an algebraic design only.
    n_hidden : int
        Number of hidden states, which come last.
    doubted : tuple of int
        States with an equation such as q' = v that the records contradict: like any other, it
        may lack something.
    """

    states: tuple[str, ...]
    inputs: tuple[str, ...]
    fixed: tuple[Sum, ...]
    columns: tuple[Column, ...]
    algebraic: bool = False
    motions: tuple[tuple[int, int], ...] = ()
    n_hidden: int = 0
    doubted: tuple[int, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the variables, numbered as in terms: states, inputs, time."""
        return (*self.states, *self.inputs, "t")

    @property
    def time(self) -> int:
        """Number of the time among the variables, the last one."""
        return len(self.states) + len(self.inputs)

    @property
    def symbols(self) -> tuple[Any, ...]:
        """Real sympy symbols of the variables, in the order of `names`."""
        return self.equations(np.zeros(len(self.columns))).symbols

    @property
    def constants(self) -> frozenset[float]:
        """Magnitudes of the numbers inside its expressions, which are known."""
        sides = (*self.fixed, *(part for column in self.columns for part in column.parts))
        products = (product for side in sides for _, product in side.parts)
        return frozenset(abs(number) for product in products for number in product.constants)

    def adding(self, columns: Iterable[Column]) -> Design:
        """Return the design with more columns at its end."""
        return replace(self, columns=(*self.columns, *columns))

    def dropping(self, columns: Iterable[Column]) -> Design:
        """Return the design without these columns."""
        gone = set(columns)
        return replace(self, columns=tuple(c for c in self.columns if c not in gone))

    def known(self, variables: np.ndarray) -> np.ndarray:
        """Return the values of the known parts, shape (n_samples, n_states)."""
        return Column("known", self.fixed).evaluate(variables)

    def sides_of(self, state: int) -> tuple[Sum, ...]:
        """Return the known part of an equation, and the part that each coefficient multiplies."""
        return (self.fixed[state], *(column.parts[state] for column in self.columns))

    def terms_of(self, state: int) -> tuple[Product, ...]:
        """Return the terms that stand in an equation, known and free ones."""
        terms = (term for side in self.sides_of(state) for _, term in side.parts)
        return tuple(dict.fromkeys(terms))

    def kinematic(self, state: int) -> bool:
        """Tell whether an equation only says that one state is the derivative of another."""
        used = any(column.parts[state].parts for column in self.columns)
        return not used and state not in self.doubted and self.derivative_of(state) is not None

    def derivative_of(self, state: int) -> int | None:
        """Return the state whose value is the whole known right-hand side of `state`."""
        return whole_state(self.fixed[state], state, len(self.states))

    def position_of(self, state: int) -> int | None:
        """Return the state whose derivative is `state`, if one is declared as such."""
        for other in range(len(self.states)):
            if self.kinematic(other) and self.derivative_of(other) == state:
                return other
        return None

    @property
    def paths(self) -> tuple[Call, ...]:
        """Operators with memory (paths) in any of the terms, whatever their coefficients are."""
        return paths_in(self.equations(np.ones(len(self.columns))))

    @property
    def velocities(self) -> tuple[int, ...]:
        """Open states that are the derivative of another state."""
        return tuple(i for i in self.open_states if self.position_of(i) is not None)

    @property
    def open_states(self) -> tuple[int, ...]:
        """States whose equations may lack something: all but the kinematic ones."""
        return tuple(i for i in range(len(self.states)) if not self.kinematic(i))

    def equations(self, coef: Sequence[float] | np.ndarray) -> Equations:
        """Return the equations with these coefficients, like terms collected."""
        rows: list[dict[Product, float]] = []
        for state in range(len(self.states)):
            row: dict[Product, float] = {term: c for c, term in self.fixed[state].parts}
            waves = []
            for value, column in zip(coef, self.columns, strict=True):
                if column.inertia is not None and column.parts[state].parts:
                    waves.append((float(value), column.inertia))
                    continue
                for c, term in column.parts[state].parts:
                    row[term] = row.get(term, 0.0) + float(value) * c
            rows.append(_over(row, waves) if waves else row)
        terms = tuple(dict.fromkeys(term for row in rows for term in row))
        matrix = np.array([[row.get(term, 0.0) for term in terms] for row in rows])
        kind = AlgebraicEquations if self.algebraic else Equations
        return kind(terms, matrix.reshape(len(rows), len(terms)), self.states, self.inputs)


def _over(
    row: dict[Product, float], waves: Sequence[tuple[float, InertiaWave]]
) -> dict[Product, float]:
    """Return the terms of an equation whose forces act on an inertia with waves."""
    rate = over_inertia(Sum(tuple((c, term) for term, c in row.items())), waves)
    return {term: c for c, term in rate.parts}
