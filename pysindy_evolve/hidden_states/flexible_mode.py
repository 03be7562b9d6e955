r"""An unmeasured mass, coupled to a measured one by a spring and a damper.

Its position h follows the position x and the velocity v of the measured mass, with an angular
frequency w0 and a damping ratio D,

    h'' = w0^2 (x - h) + 2 D w0 (v - h'),    d = (x - h) + 2 D / w0 (v - h').

Its reaction on the measured mass is proportional to d = h'' / w0^2. It describes a flexible load
behind a joint, a vibration absorber, or a resonance of the frame.

With s = (x - h)' + conj(p) (h - x) and the pole p = w0 (-D + i sqrt(1 - D^2)), the equation becomes
s' = v' + p s: a relaxation of the velocity with a complex rate. So it is an operator on the rows of
a record in time order, as in relaxing.py, and exact for a velocity that is straight between rows.

References
----------
Den Hartog, Mechanical Vibrations (1956), ISBN 978-0-486-64785-2, chapter 3: the attached mass.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import sympy

from ..operators import Operator
from ..terms import Call, Sum, add, call, constant, mul, sub, value_of
from .relaxing import relaxing_along, span_of

SUFFIX = "mode"  # the hidden states of q and v are named q_mode and v_mode
DAMPINGS = (1e-4, 0.9)  # range of D when it is fitted; an overdamped mode is two relaxations
FADED = 4.0  # time in units of 1 / (D w0) after which 2 % of the initial state are left


def stretch_along(
    v: np.ndarray,
    t: np.ndarray,
    frequency: float,
    damping: float,
    start: Sequence[float] = (0.0, 0.0),
) -> tuple[np.ndarray, np.ndarray]:
    """Return x - h and its rate along a path.

    Parameters
    ----------
    v : ndarray of shape (n_samples,)
        Velocity in time order; several records may follow each other.
    t : ndarray of shape (n_samples,)
        Times; gaps are allowed.
    frequency : float
        w0, radians per unit of t.
    damping : float
        D, dimensionless, below one.
    start : sequence of float
        x - h and its rate on the first row.

    Returns
    -------
    stretch, rate : ndarray of shape (n_samples,)
    """
    decay, damped_frequency = damping * frequency, frequency * np.sqrt(1.0 - damping**2)
    pole = complex(-decay, damped_frequency)
    start_s = complex(start[1] + decay * start[0], damped_frequency * start[0])
    s = relaxing_along(v, t, -1.0 / pole, start_s)
    return s.imag / damped_frequency, (pole * s).imag / damped_frequency


def _on_rows(
    x: np.ndarray, v: np.ndarray, t: np.ndarray, frequency: np.ndarray, damping: np.ndarray
) -> np.ndarray:
    numbers = float(frequency[0]), float(damping[0])
    stretch, rate = stretch_along(v, t, *numbers)
    return stretch + 2.0 * numbers[1] / numbers[0] * rate


def _pull(x: Any, v: Any, _: Any, frequency: Any, damping: Any) -> Any:
    h, rate = (sympy.Symbol(f"{name}_{SUFFIX}", real=True) for name in (x, v))
    return x - h + 2 * damping / frequency * (v - rate)


# Arguments: position, velocity, time, w0 and D.
FLEXIBLE_MODE = Operator("flexible_mode", _on_rows, 5, _pull)


def flexible_mode(x: Sum, v: Sum, t: Sum, frequency: float, damping: float) -> Sum:
    """Return d as a term of a position, its velocity and the time."""
    return call(FLEXIBLE_MODE, x, v, t, constant(frequency), constant(damping))


class FlexibleMode:
    """An unmeasured mass with the hidden states h and h', as a `PathKind`."""

    suffix = SUFFIX
    order = 2

    def numbers(self, path: Call) -> tuple[float, float]:
        """Return w0 and D."""
        frequency, damping = map(value_of, path.args[3:])
        return frequency, damping

    def weights(self, path: Call) -> tuple[float, ...]:
        """Return w0^2 and 2 D w0."""
        frequency, damping = self.numbers(path)
        return frequency**2, 2.0 * damping * frequency

    def numbers_from(self, weights: np.ndarray) -> tuple[float, ...]:
        """Return w0 and D from w0^2 and 2 D w0."""
        frequency = float(np.sqrt(weights[0]))
        return frequency, float(np.clip(0.5 * weights[1] / frequency, *DAMPINGS))

    def parts(self, path: Call, states: Sequence[Sum]) -> tuple[Sum, ...]:
        """Return the expressions that w0^2 and 2 D w0 multiply in the rate of h'."""
        return self._behind(path, states)

    def term(self, path: Call, states: Sequence[Sum]) -> Sum:
        """Return d."""
        frequency, damping = self.numbers(path)
        stretch, rate = self._behind(path, states)
        return add(stretch, mul(constant(2.0 * damping / frequency), rate))

    def rests(self, path: Call) -> tuple[Sum, ...]:
        """Return h and h' of a mass that moves with the measured one: x and v."""
        return path.args[:2]

    def fades(self, path: Call) -> float:
        """Return the time after which 2 % of the initial oscillation are left."""
        frequency, damping = self.numbers(path)
        return FADED / (damping * frequency)

    def describe(self, path: Call, sure: Sequence[str]) -> str:
        """Return frequency and damping in words."""
        frequency, damping = self.numbers(path)
        text = f"swings at {frequency:.4g} radians per unit of t{sure[0]}"
        return f"{text}, damping ratio {damping:.3g}{sure[1]}"

    def along(
        self, path: Call, rows: np.ndarray, starts: Sequence[float] | None = None
    ) -> np.ndarray:
        """Return h and h' on rows of a record, starting from given values, x and v by default."""
        x, v, t = (argument.evaluate(rows) for argument in path.args[:3])
        start = (0.0, 0.0) if starts is None else (x[0] - starts[0], v[0] - starts[1])
        stretch, rate = stretch_along(v, t, *self.numbers(path), start)
        return np.column_stack([x - stretch, v - rate])

    def spans(self, path: Call, rows: np.ndarray) -> list[tuple[float, float]]:
        """Return the ranges of h and h' on the first row: those of x and v, widened."""
        return [span_of(argument.evaluate(rows)) for argument in path.args[:2]]

    def _behind(self, path: Call, states: Sequence[Sum]) -> tuple[Sum, Sum]:
        """Return x - h and v - h'."""
        (x, v), (h, rate) = path.args[:2], states
        return sub(x, h), sub(v, rate)
