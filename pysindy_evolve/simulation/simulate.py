"""One run of a model from one initial state, without feeding measurements back."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, Literal

import numpy as np
from tqdm.auto import tqdm

from .. import checks
from ..equations import Equations
from ..hidden_states.memory_equations import MemoryEquations
from ..reading.library_terms import from_model
from ..warn import warn
from .freerun import SAMPLES_PER_CHUNK, FreeRun
from .inputs import Input, check_input, check_start, check_time
from .limits import Diverged, Limits
from .program import program_of
from .structure import structure_of

OnDivergence = Literal["warn", "nan", "raise"]
POINTS_PER_SAMPLE = 10  # at which an input that is a function is evaluated
MAX_STEPS, STEPS_PER_SAMPLE = 20_000, 100  # at which a run counts as too stiff
MAX_STEPS_OF_SAMPLE = 10_000  # at which one sample interval does: a pole, or much too stiff


def simulate(
    model: Any,
    x0: Any,
    t: Any,
    u: Input = None,
    *,
    substeps: int | None = None,
    tolerance: float = 1e-9,
    max_steps: int | None = None,
    bound: float = 1e15,
    on_divergence: OnDivergence = "warn",
    progress: bool = False,
) -> np.ndarray:
    """Integrate a model from one initial state, without feeding measurements back.

    Solves dx/dt = f(x, u, t) where f may jump where the argument of a sgn changes its sign. There
    the solution is Filippov's: it crosses, or it sticks until the rest of f overcomes the jump.
    A velocity that sticks is exactly zero.

    Parameters
    ----------
    model : SINDy, Equations, or an object whose `equations` are Equations
        A fitted model in continuous time.
    x0 : array-like of shape (n_states,)
        State at t[0], in the units of the data. Hidden states may be left out: they start in
        balance with the first inputs.
    t : array-like of shape (n_samples,)
        Times at which the state is wanted, strictly increasing, in units of t.
    u : array-like of shape (n_samples,) or (n_samples, n_inputs), or callable, optional
        Inputs at t, linear in between; or a function of an array of times that returns such an
        array, which is evaluated at ten points per sample. `LoopReport.simulate` runs along a
        spline instead: ``u=scipy.interpolate.CubicSpline(t, u)`` does so here. If the last input
        is named "t" and is not given, it is filled with time.
    substeps : int, optional
        Steps per sample interval, without error control. By default the error of each step is
        held below `tolerance`.
    tolerance : float
        Error of one step, relative to the largest value each state has had. Dimensionless.
    max_steps : int, optional
        Number of steps at which a run counts as too stiff; by default 20 000 and 100 for each
        sample, besides the substeps, and at most 10 000 in one sample interval.
    bound : float
        Absolute value of a state at which the run counts as diverged.
    on_divergence : {"warn", "nan", "raise"}
        What happens when the states leave the bound: the rest is NaN, with or without a
        RuntimeWarning, or a FloatingPointError is raised.
    progress : bool
        Show a progress bar.

    Returns
    -------
    ndarray of shape (n_samples, n_states)
        States at t; the first row is x0.

    Raises
    ------
    ValueError
        If t does not increase, a shape is wrong, or a value is not finite.
    FloatingPointError
        If the run diverges and `on_divergence` is "raise".

    Notes
    -----
    The cost is about 5 microseconds a sample, and some 100 for each switch. Several switches may
    stick at once. A sgn inside another sgn is followed, but nothing sticks at the inner one alone.
    An interrupted run raises KeyboardInterrupt; simulate in pieces to keep what was computed.

    Examples
    --------
    A sliding block, v' = -2 sgn(v), stops after half a second and stays at rest:

    >>> import numpy as np
    >>> from pysindy_evolve.equations import Equations
    >>> from pysindy_evolve.operators import BUILTIN
    >>> from pysindy_evolve.terms import call, only_term, variable
    >>> friction = only_term(call(BUILTIN["sgn"], variable(0)))
    >>> block = Equations((friction,), np.array([[-2.0]]), states=("v",))
    >>> simulate(block, [1.0], np.array([0.0, 0.25, 0.5, 1.0])).ravel()
    array([1. , 0.5, 0. , 0. ])
    """
    equations = from_model(model, "simulate(model=...)")
    _refuse_algebraic(equations)
    _check_options(substeps, tolerance, on_divergence)
    times = check_time(t)
    fine, keep = _refined(times, u)
    inputs = check_input(u, fine, equations)
    if isinstance(equations, MemoryEquations):
        inputs = equations.arriving(fine, inputs)
        x0 = equations.complete(np.asarray(x0, dtype=float), inputs[0], float(fine[0]))
    start = check_start(x0, equations)
    structure, parameters = structure_of(equations)
    limits = _limits(len(fine), tolerance, substeps, max_steps, bound)
    run = FreeRun(program_of(structure), parameters, limits)
    out = np.full((len(fine), len(start)), np.nan)
    out[0] = start
    failure = _fill(out, run.samples(start.tolist(), fine, inputs), bound, progress)
    if failure:
        _report(failure, out, fine, on_divergence)
    return out[::keep]


def _limits(
    n_samples: int, tolerance: float, substeps: int | None, max_steps: int | None, bound: float
) -> Limits:
    """Return the limits of a run; those of steps are above the substeps that were asked for."""
    if max_steps:
        return Limits(tolerance, substeps, max_steps, max_steps, bound)
    at_least = substeps or 0
    whole = MAX_STEPS + (STEPS_PER_SAMPLE + at_least) * n_samples
    return Limits(tolerance, substeps, whole, MAX_STEPS_OF_SAMPLE + at_least, bound)


def _refuse_algebraic(equations: Equations) -> None:
    if equations.n_algebraic:
        target = ", ".join(equations.states[: equations.n_algebraic])
        raise ValueError(
            "simulate(model=...) must be a differential equation; got an algebraic one, which "
            f"gives {target} itself. Use predict, to_callable, or LoopReport.simulate."
        )


def _fill(out: np.ndarray, samples: Iterator[Any], bound: float, progress: bool) -> Diverged | None:
    """Write samples into out, chunk by chunk; return why the run ended early, or None."""
    done, failure = 1, None
    with tqdm(total=len(out) - 1, disable=not progress, unit="sample") as bar:
        while done < len(out) and not failure:
            chunk: list[Any] = []
            try:
                for _ in range(min(SAMPLES_PER_CHUNK, len(out) - done)):
                    chunk.append(next(samples))
            except Diverged as diverged:
                failure = diverged
            if chunk:
                block = np.array(chunk, dtype=float)
                out[done : done + len(block)] = block
                outside = ~np.all(np.abs(block) <= bound, axis=1)
                if outside.any():
                    out[done + int(np.argmax(outside)) :] = np.nan
                    failure = Diverged(f"a state left the bound of {bound:g}")
                done += len(block)
                bar.update(len(block))
    return failure


def _report(failure: Diverged, out: np.ndarray, t: np.ndarray, on_divergence: str) -> None:
    at = int(np.argmax(np.isnan(out).any(axis=1)))
    message = (
        f"simulate: the run {failure.outcome} at t = {t[at]:.6g} (sample {at}): {failure}. "
        f"The rest is NaN. {failure.advice}"
    )
    if on_divergence == "raise":
        raise FloatingPointError(message)
    if on_divergence == "warn":
        warn(message, RuntimeWarning)


def _refined(t: np.ndarray, u: Input) -> tuple[np.ndarray, int]:
    """Put more points between samples where the input is a function."""
    if not callable(u):
        return t, 1
    n = POINTS_PER_SAMPLE
    return np.interp(np.arange((len(t) - 1) * n + 1) / n, np.arange(len(t)), t), n


def _check_options(substeps: int | None, tolerance: float, on_divergence: str) -> None:
    if substeps is not None:
        advice = "Leave it out to have the error controlled."
        checks.count("simulate", "substeps", substeps, advice=advice)
    if not (math.isfinite(tolerance) and tolerance > 0):
        checks.refuse("simulate", "tolerance", "above 0", repr(tolerance), "Give, say, 1e-9.")
    if on_divergence not in ("warn", "nan", "raise"):
        must = '"warn", "nan" or "raise"'
        checks.refuse("simulate", "on_divergence", must, repr(on_divergence), "Choose one of them.")
