"""One effect with its evidence, one alternative of it, and the errors of one model."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ...equations import Equations
from ...export import format_expression, to_sympy
from ...hidden_states.memory import Memory
from ...terms import Sum


@dataclass(frozen=True, eq=False)
class Errors:
    """Errors of a model on held-out data, in percent of the standard deviation (NRMSE).

    Attributes
    ----------
    derivative_error : ndarray of shape (n_states,)
        Of x_dot, both sides averaged over the windows of the fit.
    simulation_error : ndarray of shape (n_states,)
        Of a free run from the first state of each record; infinite if it diverges.
    model : Equations
        The model that the errors belong to.
    parameters : mapping of str to float
        Fitted values of the free parameters that were declared.
    parameter_intervals : mapping of str to ndarray of shape (2,)
        95 % interval of each. Empty for a model that lacks something: the missing part biases its
        parameters.
    undefined : float
        Share of the held-out rows in which the model has no finite value, such as the root of a
        negative number; the derivative error leaves them out.
    """

    derivative_error: np.ndarray
    simulation_error: np.ndarray
    model: Equations
    parameters: Mapping[str, float] = field(default_factory=dict)
    parameter_intervals: Mapping[str, np.ndarray] = field(default_factory=dict)
    undefined: float = 0.0

    @property
    def equations(self) -> list[Any]:
        """Right-hand sides as sympy expressions, one for each state."""
        return to_sympy(self.model)


@dataclass(frozen=True, eq=False)
class Alternative:
    """Another effect that could have caused the same record.

    Attributes
    ----------
    name : str
        From the vocabulary.
    state : str
        State whose equation it would enter.
    term : sympy.Expr
        The alternative without coefficient; with several terms, their sum.
    p_value : float
        If the alternative were the true cause: the chance that the found effect, added beside it,
        would gain as much as it does here.
    expressions : tuple of Sum
        The terms.
    coefficients : ndarray of shape (n_terms,)
        Of the terms, fitted in place of the found effect; empty for a memory.
    force : sympy.Expr
        The terms times these coefficients; for a memory, the term.
    """

    name: str
    state: str
    term: Any
    p_value: float
    expressions: tuple[Sum, ...]
    coefficients: np.ndarray = field(default_factory=lambda: np.empty(0))
    force: Any = None


@dataclass(frozen=True, eq=False, repr=False)
class Effect:
    """One effect that the declared model lacks.

    Attributes
    ----------
    name : str
        From the vocabulary.
    state : str
        State whose equation it enters.
    term : sympy.Expr
        The effect without coefficient; with several terms, their sum.
    coefficients : ndarray of shape (n_terms,)
        In the order of `expressions`, in units of the derivative of the state per unit of the term.
        The terms of the sympy sum `term` may be in another order.
    confidence_intervals : ndarray of shape (n_terms, 2)
        95 %, from a bootstrap over blocks of the training data.
    explained : float
        Share of the variance of the held-out derivative residual that it removed when it was
        added, beside the other effects of the same step and of those before.
    p_value : float
        Chance of a score as large in a twin, where nothing is missing. An effect that took the
        place of another one keeps the p-value of that one.
    alternatives : tuple of str
        Names of other effects that this record cannot tell from it. Other forms of the effect
        itself are in `rivals` only.
    expressions : tuple of Sum
        The terms. Each has a `to_sympy`.
    twin_scores : ndarray of shape (n_twins,)
        Best score in each twin.
    score : float
        Score in the record.
    rivals : tuple of Alternative
        The alternatives with their terms, and other forms of the effect itself.
    together : tuple of str
        Names of the single effect that it forms with another effect of its equation: friction
        beside an offset is asymmetric friction. They are among the alternatives.
    contested : bool
        Whether other effects were tried in its place. False for a limit, a memory that only free
        runs show, and an effect that another one builds on.
    memory : Memory, optional
        For a memory of an input: its kind and its numbers.
    by_runs : bool
        Whether free runs showed it; `explained` then is the share of the variance of their error
        that its step removed.
    quantities : tuple of str
        Meaning of the `coefficients` if they multiply no term: the delay or time constant of a
        memory, in units of t, or the limit of a state or of its sensor.
    of_sensor : bool
        Whether it acts in the sensor of the state, and not in its equation.
    numbers : mapping of str to float
        The tuned numbers inside its terms, such as a half width or a Stribeck speed.
    number_intervals : ndarray of shape (n_numbers, 2)
        95 % interval of each, with the coefficients free; nan where the data do not determine it.
    entry : str
        Where it acts, if a declared force enters the equation by the same factor, which is not
        constant: such as "as if F were larger by this number times sgn(v)", or "through the same
        factor as the damping of w", or "where M1 and M2 act, as this number times cos(q1 + q2)".
    written : tuple of Sum
        Terms to print beside the coefficients where `expressions` hold the whole equation: the
        waves of an inertia.
    """

    name: str
    state: str
    term: Any
    coefficients: np.ndarray
    confidence_intervals: np.ndarray
    explained: float
    p_value: float
    alternatives: tuple[str, ...]
    expressions: tuple[Sum, ...]
    twin_scores: np.ndarray
    score: float
    rivals: tuple[Alternative, ...] = ()
    contested: bool = False
    memory: Memory | None = None
    by_runs: bool = False
    quantities: tuple[str, ...] = ()
    of_sensor: bool = False
    numbers: Mapping[str, float] = field(default_factory=dict)
    number_intervals: np.ndarray = field(default_factory=lambda: np.empty((0, 2)))
    entry: str = ""
    together: tuple[str, ...] = ()
    written: tuple[Sum, ...] = ()

    @property
    def place(self) -> str:
        """Where it acts: in the equation of a state, or in its sensor."""
        return f"the {'sensor' if self.of_sensor else 'equation'} of {self.state}"

    @property
    def is_limit(self) -> bool:
        """Whether it is a limit of a state or its sensor; its score is then samples in a row."""
        return bool(self.quantities) and self.memory is None

    def __repr__(self) -> str:
        intervals = zip(self.coefficients, self.confidence_intervals, strict=True)
        values = ", ".join(f"{c:.4g} ({low:.4g} to {high:.4g})" for c, (low, high) in intervals)
        return (
            f"Effect({self.name!r}, state={self.state!r}, term={format_expression(self.term)}, "
            f"coefficients=[{values}], p_value={self.p_value:.2g})"
        )


@dataclass(frozen=True, eq=False)
class Step:
    """The errors after one effect was added; the effects of a pair share them."""

    name: str
    state: str
    errors: Errors

    @property
    def derivative_error(self) -> np.ndarray:
        """NRMSE of the derivative, percent for each state."""
        return self.errors.derivative_error

    @property
    def simulation_error(self) -> np.ndarray:
        """NRMSE of the free run, percent for each state."""
        return self.errors.simulation_error
