"""Checks of the times, initial states and inputs of a simulation."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from .. import checks
from ..equations import Equations

Input = np.ndarray | Callable[[np.ndarray], Any] | None


def check_time(t: Any) -> np.ndarray:
    """Return t of shape (n_samples,), strictly increasing."""
    times = checks.floats("simulate", "t", t)
    if times.ndim != 1 or len(times) < 2:
        raise ValueError(
            f"simulate(t=...) must be a 1-D array of at least 2 times; got shape {times.shape}. "
            "Give the times of all samples."
        )
    checks.increasing("simulate", times)
    return times


def check_start(x0: Any, equations: Equations) -> np.ndarray:
    """Return x0 of shape (n_states,)."""
    start = checks.floats("simulate", "x0", x0)
    n_states = len(equations.states)
    if start.shape != (n_states,):
        raise ValueError(
            f"simulate(x0=...) must hold {n_states} values, one for each of "
            f"{', '.join(equations.states)}; got shape {start.shape}. Give the initial state."
        )
    return start


def check_input(u: Input, t: np.ndarray, equations: Equations) -> np.ndarray:
    """Return u of shape (n_samples, n_inputs), with an input named t filled by time."""
    names = equations.inputs
    if u is None:
        given = np.empty((len(t), 0))
    else:
        given = checks.floats("simulate", "u", u(t) if callable(u) else u)
    if given.ndim == 1:
        given = given[:, None]
    if names and names[-1] == "t" and given.shape[-1] == len(names) - 1:
        given = np.column_stack([given, t]) if len(given) == len(t) else given
    if u is None and given.shape[1] != len(names):
        raise ValueError(
            f"simulate(u=...) must be given: the equations have the inputs {', '.join(names)}; "
            f"got None. Give an array of shape ({len(t)}, {len(names)})."
        )
    if given.shape != (len(t), len(names)):
        advice = "Give one row a sample and one column an input."
        if not names:
            advice = "Leave u out: the equations have no inputs."
        raise ValueError(
            f"simulate(u=...) must have shape ({len(t)}, {len(names)}); got {given.shape}. {advice}"
        )
    return given
