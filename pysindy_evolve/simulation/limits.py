"""Limits of a free run, and how it ends where it exceeds one."""

from __future__ import annotations

from dataclasses import dataclass


class Diverged(Exception):
    """The states are not finite, or the right-hand side has no value."""

    outcome = "diverged"
    advice = "Check the coefficients and x0, or give t in shorter steps if the model is stiff."


class TooManySteps(Diverged):
    """A mode is so fast that its steps are too many."""

    outcome = "stopped"
    advice = "If the model is right, it has a mode much faster than the samples: raise max_steps."


class TooShortSteps(Diverged):
    """The error stays above the tolerance in the shortest steps."""

    outcome = "stopped"
    advice = "Give t in shorter steps; a jump at which the motion may stick must be a sgn."


@dataclass(frozen=True)
class Limits:
    """When to cut a step and when to give up.

    Attributes
    ----------
    tolerance : float
        Error of one step, relative to the largest value a state has had.
    substeps : int or None
        Steps in each sample interval without error control, or None to control the error.
    max_steps : int
        Steps in the whole run.
    max_steps_of_sample : int
        Steps in one sample interval: many fewer, so that a pole costs little time.
    bound : float
        Largest absolute value of a state.
    """

    tolerance: float
    substeps: int | None
    max_steps: int
    max_steps_of_sample: int
    bound: float
