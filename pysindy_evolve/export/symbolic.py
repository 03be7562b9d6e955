"""Equations as sympy expressions, and the form that all other views start from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import reduce
from typing import Any

from .. import terms
from ..equations import Equations
from ..hidden_states.memory_equations import MemoryEquations
from ..reading.library_terms import from_model
from ..terms import ONE, Product, Sum, of_term
from .compact import as_fractions
from .hinges import as_hinges


def to_sympy(model: Any, digits: int | None = None) -> list[Any]:
    """Return the right-hand sides as sympy expressions.

    Like terms are collected, ``v*sign(v)`` is ``Abs(v)``, and symbols are real. Use ``expand`` and
    ``collect`` on the result, but not ``simplify``, which turns ``sign`` into a Piecewise.

    Parameters
    ----------
    model : pysindy.SINDy, Equations or LoopReport
        Fitted model with any library of ordinary terms, or an object that holds one.
    digits : int, optional
        Significant digits of all numbers; by default they are exact.

    Returns
    -------
    list of sympy.Expr
        One for each state, in units of the state per unit of t.

    Raises
    ------
    TypeError
        If `model` is no model, or its library is one of partial derivatives or weak forms.
    sklearn.exceptions.NotFittedError
        If `model` has not been fitted.
    ValueError
        If two variables share a name, or `digits` is below 1.

    Examples
    --------
    >>> import numpy as np, pysindy as ps
    >>> x = np.exp(-0.5 * np.linspace(0, 4, 50)).reshape(-1, 1)
    >>> model = ps.SINDy(feature_library=ps.PolynomialLibrary(degree=1))
    >>> to_sympy(model.fit(x, t=0.1, x_dot=-0.5 * x, feature_names=["q"]), digits=6)
    [-0.5*q]
    """
    system = system_of(model, "to_sympy", digits)
    return [side.to_sympy(system.equations.symbols) for side in system.sides]


@dataclass(frozen=True)
class System:
    """Equations with one collected sum for each left-hand side."""

    equations: Equations
    lefts: tuple[str, ...]
    sides: tuple[Sum, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the variables: states, inputs, time."""
        return self.equations.names

    @property
    def are_rates(self) -> tuple[bool, ...]:
        """Whether each right-hand side is the rate of its state, not the state itself."""
        return tuple(k >= self.equations.n_algebraic for k in range(len(self.sides)))

    @property
    def used(self) -> tuple[int, ...]:
        """Columns of the variables that occur in some equation."""
        return tuple(sorted(frozenset().union(*(side.variables for side in self.sides))))


def system_of(model: Any, owner: str, digits: int | None = None) -> System:
    """Read a model for the view `owner`, like terms collected and numbers rounded."""
    equations = from_model(model, f"{owner}(model=...)")
    names = (*equations.states, *equations.inputs)
    for name in names:
        if names.count(name) > 1:
            raise ValueError(
                f"{owner}(model=...) must have a name of its own for each variable; "
                f"got {name!r} twice. Fit with other feature_names."
            )
    sides = tuple(as_hinges(_collected(side)) for side in equations.sums)
    if digits is not None:
        if not isinstance(digits, int) or digits < 1:
            raise ValueError(
                f"{owner}(digits=...) must be a positive integer or None; got {digits!r}. "
                "Give a number of significant digits."
            )
        sides = tuple(_rounded(side, digits) for side in sides)
        if isinstance(equations, MemoryEquations):
            late = tuple(round_to(delay, digits) for delay in equations.delays)
            equations = replace(equations, delays=late)
    lefts = equations.states
    if len(lefts) != len(sides):  # a model of some target that is not the rate of each state
        lefts = tuple(f"target{i}" for i in range(len(sides)))
    return System(equations, lefts, sides)


def constant_last(side: Sum) -> list[tuple[float, Product]]:
    """Return coefficients and terms in the order in which they are shown."""
    return sorted(side.parts, key=lambda part: part[1] == ONE)


def as_shown(side: Sum, symbols: Sequence[Any]) -> list[tuple[float, Any]]:
    """Return coefficients and sympy terms as they are written in a line, fractions as one term."""
    parts = ((c, term.to_sympy(symbols)) for c, term in constant_last(as_fractions(side)))
    bare = ((c, *without_sign(term)) for c, term in parts)
    return [(sign * c, term) for c, sign, term in bare]


def without_sign(term: Any) -> tuple[int, Any]:
    """Return the sign of a sympy term, 1 or -1, and the term without it.

    Sympy takes the sign out of an odd function, as in -tanh(v). The caller multiplies it into the
    coefficient, as two signs in a row are hard to read.
    """
    return (-1, -term) if term.as_coeff_Mul()[0].is_negative else (1, term)


def round_to(value: float, digits: int | None) -> float:
    """Round to significant digits."""
    return value if digits is None else float(f"{value:.{digits}g}")


def _rounded(side: Sum, digits: int) -> Sum:
    return side.with_constants([round_to(value, digits) for value in side.constants])


def _collected(side: Sum) -> Sum:
    """Collect like terms; a term that is only a sum is multiplied out."""
    parts = (terms.mul(terms.constant(c), _opened(term)) for c, term in side.parts)
    return reduce(terms.add, parts, Sum(()))


def _opened(term: Product) -> Sum:
    if len(term.factors) == 1:
        ((atom, exponent),) = term.factors
        if isinstance(atom, Sum) and exponent == 1:
            return atom
    return of_term(term)
