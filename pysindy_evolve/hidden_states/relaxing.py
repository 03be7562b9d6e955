r"""Relaxation: a spring in series with a damper, or an unmeasured heat capacity.

A hidden state h follows a measured state x with a first-order lag, and their difference d acts,

    T h' = x - h,    d = x - h.

For a position x, d is the stretch of the spring of a Maxwell element, whose force decays with the
relaxation time T. Together with a parallel spring it is the standard linear solid, a model of
rubber and of creep. For a temperature x, h is the temperature of a body that only x heats.

It is an operator on the rows of a record in time order, like Bouc and Wen's hysteresis, and enters
a model like any other term. It is exact for an x that is straight between rows. Where the times go
back another record begins, with h in balance.

References
----------
Lakes, Viscoelastic Materials (2009), ISBN 978-0-521-88568-3, chapter 2.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import sympy
from scipy.signal import lfilter

from ..operators import Operator
from ..terms import Call, Sum, call, constant, sub, value_of

SUFFIX = "relax"  # the hidden state of q is named q_relax
FADED = 4.0  # relaxation times after which 2 % of the initial state are left
STEP_TOLERANCE = 0.01  # deviation from the median time step, relative to it, that counts as uniform


def relaxing_along(
    x: np.ndarray, t: np.ndarray, relaxation_time: complex, start: complex = 0.0
) -> np.ndarray:
    """Return d along a path.

    Parameters
    ----------
    x : ndarray of shape (n_samples,)
        Values in time order; several records may follow each other.
    t : ndarray of shape (n_samples,)
        Times; gaps are allowed.
    relaxation_time : float or complex
        T, units of t; with a complex one d oscillates while it decays.
    start : float or complex
        d on the first row, units of x.

    Returns
    -------
    ndarray of shape (n_samples,)
    """
    d = np.empty(len(x), dtype=type(start / relaxation_time))
    steps, moves = np.diff(t), np.diff(x)
    usual = float(np.median(steps)) if len(steps) else 0.0
    breaks = np.flatnonzero(np.abs(steps - usual) > STEP_TOLERANCE * abs(usual))
    first, value = 0, start
    for last in (*breaks.tolist(), len(steps)):
        d[first : last + 1] = _on_steps(moves[first:last], usual / relaxation_time, value)
        if last < len(steps):
            ratio = float(steps[last]) / relaxation_time
            continues = steps[last] > 0.0  # else another record begins
            value = _on_steps(moves[last : last + 1], ratio, d[last])[-1] if continues else 0.0
        first = last + 1
    return d


def _on_steps(moves: np.ndarray, step: complex, start: complex) -> np.ndarray:
    """Return d on uniform time steps, from the changes of x; the step in relaxation times."""
    if not len(moves):
        return np.array([start])
    decay, gain = np.exp(-step), -np.expm1(-step) / step
    d, _ = lfilter([gain], [1.0, -decay], moves, zi=[decay * start])
    return np.concatenate([[start], d])


def span_of(x: np.ndarray) -> tuple[float, float]:
    """Return the range of values, widened by its width at both ends.

    A state that decays may have been larger before the record.
    """
    width = float(np.ptp(x))
    return float(x.min()) - width, float(x.max()) + width


def _on_rows(x: np.ndarray, t: np.ndarray, relaxation_time: np.ndarray) -> np.ndarray:
    return relaxing_along(x, t, float(relaxation_time[0]))


def _stretch(x: Any, *_: Any) -> Any:
    return x - sympy.Symbol(f"{x}_{SUFFIX}", real=True)


# Arguments: a state, the time and T.
RELAXING = Operator("relaxing", _on_rows, 3, _stretch)


def relaxing(x: Sum, t: Sum, relaxation_time: float) -> Sum:
    """Return d as a term of a state and the time."""
    return call(RELAXING, x, t, constant(relaxation_time))


class Relaxation:
    """Relaxation as a `PathKind`."""

    suffix = SUFFIX
    order = 1

    def numbers(self, path: Call) -> tuple[float]:
        """Return T."""
        return (value_of(path.args[2]),)

    def weights(self, path: Call) -> tuple[float, ...]:
        """Return 1 / T."""
        (relaxation_time,) = self.numbers(path)
        return (1.0 / relaxation_time,)

    def numbers_from(self, weights: np.ndarray) -> tuple[float, ...]:
        """Return T from 1 / T."""
        return (1.0 / float(weights[0]),)

    def parts(self, path: Call, states: Sequence[Sum]) -> tuple[Sum, ...]:
        """Return the expression that 1 / T multiplies in the rate of h."""
        return (self.term(path, states),)

    def term(self, path: Call, states: Sequence[Sum]) -> Sum:
        """Return d."""
        return sub(path.args[0], states[0])

    def rests(self, path: Call) -> tuple[Sum, ...]:
        """Return h in balance: x."""
        return path.args[:1]

    def fades(self, path: Call) -> float:
        """Return the time after which 2 % of the initial d are left."""
        return FADED * self.numbers(path)[0]

    def describe(self, path: Call, sure: Sequence[str]) -> str:
        """Return the relaxation time in words."""
        return f"relaxation time {self.numbers(path)[0]:.4g}{sure[0]}"

    def along(
        self, path: Call, rows: np.ndarray, starts: Sequence[float] | None = None
    ) -> np.ndarray:
        """Return h on rows of a record, starting from a value on the first row, x by default."""
        x, t = (argument.evaluate(rows) for argument in path.args[:2])
        start = 0.0 if starts is None else float(x[0]) - starts[0]
        return (x - relaxing_along(x, t, *self.numbers(path), start))[:, None]

    def spans(self, path: Call, rows: np.ndarray) -> list[tuple[float, float]]:
        """Return the range of h on the first row: that of x, widened."""
        return [span_of(path.args[0].evaluate(rows))]
