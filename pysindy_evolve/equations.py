"""Equations: terms, coefficients and names; what is scored, printed, simulated and exported.

======  =============================  =====================================================
symbol  shape                          meaning
======  =============================  =====================================================
x       (n_samples, n_states)          states
u       (n_samples, n_inputs)          inputs
t       (n_samples,)                   time, the last variable of the terms, if they need it
theta   (n_samples, n_terms)           dictionary: each term evaluated on each sample
coef    (n_states, n_terms)            x_dot = theta @ coef.T
======  =============================  =====================================================
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import sympy

from .terms import Cache, Product, Sum


@dataclass(frozen=True, eq=False)
class Equations:
    """The right-hand sides of a system of differential equations, linear in their terms.

    Parameters
    ----------
    terms : tuple of Product
        Columns of the dictionary. Variables are numbered: states, inputs, time.
    coef : ndarray of shape (n_states, n_terms)
        Coefficients, in units of x_dot per unit of the term.
    states : tuple of str
        Names of the states.
    inputs : tuple of str
        Names of the inputs.
    """

    terms: tuple[Product, ...]
    coef: np.ndarray
    states: tuple[str, ...]
    inputs: tuple[str, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the variables: states, inputs, time."""
        return (*self.states, *self.inputs, "t")

    @property
    def symbols(self) -> tuple[Any, ...]:
        """Real sympy symbols of the variables, in the order of `names`."""
        return tuple(sympy.Symbol(name, real=True) for name in self.names)

    @property
    def inner_symbols(self) -> tuple[Any, ...]:
        """Symbols that terms are printed with; the same unless hidden states were added."""
        return self.symbols

    @property
    def n_algebraic(self) -> int:
        """Number of leading states that the right-hand sides give directly, not as rates."""
        return 0

    @property
    def used(self) -> np.ndarray:
        """Indices of the terms that have a coefficient in some row."""
        return np.flatnonzero(np.any(self.coef != 0.0, axis=0))

    @property
    def needs_time(self) -> bool:
        """Whether a term with a coefficient depends on t itself."""
        last = len(self.names) - 1
        return any(last in self.terms[i].variables for i in self.used)

    @property
    def sums(self) -> tuple[Sum, ...]:
        """The right-hand side of each state."""
        return tuple(
            Sum(tuple((float(c), term) for c, term in zip(row, self.terms, strict=True) if c))
            for row in self.coef
        )

    def theta(
        self, x: np.ndarray, u: np.ndarray | None = None, t: np.ndarray | None = None
    ) -> np.ndarray:
        """Evaluate the dictionary.

        Parameters
        ----------
        x : ndarray of shape (n_samples, n_states)
            States.
        u : ndarray of shape (n_samples, n_inputs), optional
            Inputs.
        t : ndarray of shape (n_samples,), optional
            Time, needed where a term depends on it.

        Returns
        -------
        ndarray of shape (n_samples, n_terms)
        """
        variables = stack(x, u, t)
        cache: Cache = {}
        columns = [term.evaluate(variables, cache) for term in self.terms]
        return np.array(columns).T if columns else np.empty((len(x), 0))

    def evaluate(
        self, x: np.ndarray, u: np.ndarray | None = None, t: np.ndarray | None = None
    ) -> np.ndarray:
        """Evaluate the right-hand sides: x_dot of shape (n_samples, n_states)."""
        return self.theta(x, u, t) @ self.coef.T

    def to_sympy(self) -> list[Any]:
        """Return the right-hand sides as sympy expressions, one for each state."""
        return [expression.to_sympy(self.symbols) for expression in self.sums]


@dataclass(frozen=True, eq=False)
class AlgebraicEquations(Equations):
    """Right-hand sides that give the target itself, such as a force, instead of its rate."""

    @property
    def n_algebraic(self) -> int:
        """Number of states: all of them."""
        return len(self.states)


def collected(sides: Sequence[Sum]) -> tuple[tuple[Product, ...], np.ndarray]:
    """Return the terms of right-hand sides and their coefficients, shape (n_sides, n_terms)."""
    terms = tuple(dict.fromkeys(term for side in sides for _, term in side.parts))
    coef = np.zeros((len(sides), len(terms)))
    for row, side in zip(coef, sides, strict=True):
        for c, term in side.parts:
            row[terms.index(term)] += c
    return terms, coef


def stack(x: np.ndarray, u: np.ndarray | None = None, t: np.ndarray | None = None) -> np.ndarray:
    """Put states, inputs and time side by side: shape (n_samples, n_variables)."""
    columns: Sequence[np.ndarray] = [part for part in (x, u, t) if part is not None]
    return np.column_stack([np.asarray(c, dtype=float) for c in columns])
