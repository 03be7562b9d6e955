"""Check what a simulation is given, in the house form of errors."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ..equations import Equations

__all__ = ["check_input", "check_start", "check_time"]

Input = np.ndarray | Callable[[np.ndarray], Any] | None


def check_time(t: Any, owner: str) -> np.ndarray:
    """Return t of shape (n_samples,), strictly increasing."""
    times = _as_floats(t, "t", owner)
    if times.ndim != 1 or len(times) < 2:
        raise ValueError(
            f"{owner}(t=...) must be a 1-D array of at least 2 times; got shape {times.shape}. "
            "Give the times of all samples."
        )
    steps = np.diff(times)
    if np.any(steps <= 0):
        at = int(np.argmax(steps <= 0))
        raise ValueError(
            f"{owner}(t=...) must be strictly increasing; got a step of {steps[at]:g} at sample "
            f"{at + 1}. Sort the record or drop the repeated samples."
        )
    return times


def check_start(x0: Any, equations: Equations, owner: str) -> np.ndarray:
    """Return x0 of shape (n_states,)."""
    start = _as_floats(x0, "x0", owner)
    n_states = len(equations.states)
    if start.shape != (n_states,):
        raise ValueError(
            f"{owner}(x0=...) must hold {n_states} values, one for each of "
            f"{', '.join(equations.states)}; got shape {start.shape}. Give the initial state."
        )
    return start


def check_input(u: Input, t: np.ndarray, equations: Equations, owner: str) -> np.ndarray:
    """Return u of shape (n_samples, n_inputs), with an input named t filled by time."""
    names = equations.inputs
    if u is None:
        given = np.empty((len(t), 0))
    else:
        given = _as_floats(u(t) if callable(u) else u, "u", owner)
    if given.ndim == 1:
        given = given[:, None]
    if names and names[-1] == "t" and given.shape[-1] == len(names) - 1:
        given = np.column_stack([given, t]) if len(given) == len(t) else given
    if u is None and given.shape[1] != len(names):
        raise ValueError(
            f"{owner}(u=...) must be given: the equations have the inputs {', '.join(names)}; "
            f"got None. Give an array of shape ({len(t)}, {len(names)})."
        )
    if given.shape != (len(t), len(names)):
        advice = "Give one row a sample and one column an input."
        if not names:
            advice = "Leave u out: the equations have no inputs."
        raise ValueError(
            f"{owner}(u=...) must have shape ({len(t)}, {len(names)}); got {given.shape}. {advice}"
        )
    return given


def _as_floats(value: Any, name: str, owner: str) -> np.ndarray:
    try:
        array = np.asarray(value, dtype=float)
    except (TypeError, ValueError) as error:
        raise TypeError(
            f"{owner}({name}=...) must be an array of numbers; got {type(value).__name__}. "
            "Convert it to floats."
        ) from error
    if not np.all(np.isfinite(array)):
        at = np.unravel_index(int(np.argmin(np.isfinite(array))), array.shape)
        raise ValueError(
            f"{owner}({name}=...) must be finite; got {array[at]} at {tuple(map(int, at))}. "
            "Drop or fill these samples."
        )
    return array
