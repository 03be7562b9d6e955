"""Equations as a function of arrays."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NoReturn

import numpy as np

from .. import checks
from ..equations import Equations
from .symbolic import system_of


def to_callable(model: Any) -> RightHandSideFunction:
    """Return the right-hand sides as a function ``f(t, x, u=None)``.

    It gives the numbers of ``model.predict``, needs no PySINDy, and pickles if the functions in the
    model do.

    Parameters
    ----------
    model : pysindy.SINDy, Equations or LoopReport
        Fitted model, or an object that holds one.

    Returns
    -------
    RightHandSideFunction

    Raises
    ------
    TypeError
        If `model` is no model, or its library is one of partial derivatives or weak forms.
    sklearn.exceptions.NotFittedError
        If `model` has not been fitted.
    ValueError
        If two variables share a name.

    Examples
    --------
    >>> import numpy as np
    >>> from pysindy_evolve.terms import only_term, variable
    >>> term = only_term(variable(0))
    >>> f = to_callable(Equations((term,), np.array([[-2.0]]), ("q",)))
    >>> f(0.0, [3.0])
    array([-6.])
    """
    return RightHandSideFunction(system_of(model, "to_callable").equations)


@dataclass(frozen=True)
class RightHandSideFunction:
    """x_dot = f(t, x, u), for one sample or for many.

    Attributes
    ----------
    equations : Equations
        The right-hand sides.
    """

    equations: Equations

    def __call__(self, t: Any, x: Any, u: Any = None) -> np.ndarray:
        """Evaluate the right-hand sides.

        Parameters
        ----------
        t : float or ndarray of shape (n_samples,)
            Time.
        x : ndarray of shape (n_states,) or (n_samples, n_states)
            States.
        u : float or ndarray of shape (n_inputs,) or (n_samples, n_inputs), optional
            Inputs; a single one also as (n_samples,). One sample is used for all samples of x.

        Returns
        -------
        ndarray of the shape of x
            Rates, in units of x per unit of t.

        Raises
        ------
        ValueError
            If a shape does not fit the model.
        """
        n_states, n_inputs = len(self.equations.states), len(self.equations.inputs)
        states = np.asarray(x, dtype=float)
        if states.ndim not in (1, 2) or states.shape[-1] != n_states:
            _refuse("x", f"of shape ({n_states},) or (n_samples, {n_states})", states)
        rows = np.atleast_2d(states)
        times = np.asarray(t, dtype=float)
        if times.ndim > 1 or times.size not in (1, len(rows)):
            _refuse("t", f"a number or of shape ({len(rows)},)", times)
        inputs = _rows(u, len(rows), n_inputs) if n_inputs else None
        result = self.equations.evaluate(rows, inputs, np.broadcast_to(times, len(rows)))
        return result if states.ndim == 2 else result[0]


def _rows(u: Any, n_samples: int, n_inputs: int) -> np.ndarray:
    constraint = f"of shape ({n_inputs},) or ({n_samples}, {n_inputs})"
    if u is None:
        _refuse("u", constraint, None)
    inputs = np.asarray(u, dtype=float)
    if n_inputs == 1 and inputs.shape in ((), (n_samples,)):
        inputs = inputs.reshape(-1, 1)
    if inputs.shape not in ((n_inputs,), (1, n_inputs), (n_samples, n_inputs)):
        _refuse("u", constraint, inputs)
    return np.broadcast_to(inputs, (n_samples, n_inputs))


def _refuse(parameter: str, constraint: str, value: np.ndarray | None) -> NoReturn:
    got = "None" if value is None else f"shape {value.shape}"
    advice = "Give one row for each sample."
    checks.refuse("to_callable(model)", parameter, constraint, got, advice)
