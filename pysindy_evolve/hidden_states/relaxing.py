r"""What relaxes: the stretch of a spring in series with a damper, a heat capacity nobody measured.

A hidden state h runs after a measured state x, and what acts is how far x is ahead of it,

    T h' = x - h,    d = x - h.

For a position x, d is the stretch of the spring of a Maxwell element, whose force has faded after
the relaxation time T; beside another spring it makes the standard linear solid, of rubber and of
whatever creeps. For a temperature, h is that of a body which only x heats.

It is an operator on the rows of a record in time order, as Bouc and Wen's hysteresis is, and enters
a model as any other term does. Between two rows x is taken to be straight, for which it is exact.
Where the times go back another record begins, and there h is in balance.

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
from ..terms import Call, Sum, call, constant, sub

__all__ = ["RELAXING", "Relaxation", "relaxing", "relaxing_along", "span_of"]

SUFFIX = "relax"  # what the name of the hidden state ends in, after that of the measured one
FADED = 4.0  # relaxation times, after which 2 % are left of how it began
EVEN = 0.01  # of a step, that others of a uniform record may differ from it


def relaxing_along(
    x: np.ndarray, t: np.ndarray, relaxation_time: complex, start: complex = 0.0
) -> np.ndarray:
    """Return d along a path.

    Parameters
    ----------
    x : ndarray of shape (n_samples,)
        Values in time order, perhaps of several records, one after the other.
    t : ndarray of shape (n_samples,)
        Times. Pieces may be missing.
    relaxation_time : float or complex
        T, units of t; a complex one swings while it fades.
    start : float or complex
        d on the first row, units of x.

    Returns
    -------
    ndarray of shape (n_samples,)
    """
    d = np.empty(len(x), dtype=type(start / relaxation_time))
    steps, moves = np.diff(t), np.diff(x)
    usual = float(np.median(steps)) if len(steps) else 0.0
    breaks = np.flatnonzero(np.abs(steps - usual) > EVEN * abs(usual))
    begins, value = 0, start
    for end in (*breaks.tolist(), len(steps)):
        d[begins : end + 1] = _evenly(moves[begins:end], usual / relaxation_time, value)
        if end < len(steps):
            ratio = float(steps[end]) / relaxation_time
            goes_on = steps[end] > 0.0  # or another record begins
            value = _evenly(moves[end : end + 1], ratio, d[end])[-1] if goes_on else 0.0
        begins = end + 1
    return d


def _evenly(moves: np.ndarray, ratio: complex, start: complex) -> np.ndarray:
    """Return d on even steps of so many relaxation times, from the changes of x on each."""
    if not len(moves):
        return np.array([start])
    faded, share = np.exp(-ratio), -np.expm1(-ratio) / ratio
    moved, _ = lfilter([share], [1.0, -faded], moves, zi=[faded * start])
    return np.concatenate([[start], moved])


def span_of(x: np.ndarray) -> tuple[float, float]:
    """Return the range of values, and as far beyond: what dies out was larger before a record."""
    width = float(np.ptp(x))
    return float(x.min()) - width, float(x.max()) + width


def _on_rows(x: np.ndarray, t: np.ndarray, relaxation_time: np.ndarray) -> np.ndarray:
    return relaxing_along(x, t, float(relaxation_time[0]))


def _stretch(x: Any, *_: Any) -> Any:
    return x - sympy.Symbol(f"{x}_{SUFFIX}", real=True)


# Of a state, the time and T.
RELAXING = Operator("relaxing", _on_rows, 3, _stretch)


def relaxing(x: Sum, t: Sum, relaxation_time: float) -> Sum:
    """Return d as a term of a state and the time."""
    return call(RELAXING, x, t, constant(relaxation_time))


class Relaxation:
    """What a model needs to know of h; see `PathKind`."""

    suffix = SUFFIX
    order = 1

    def numbers(self, path: Call) -> tuple[float]:
        """Return T."""
        return (float(path.args[2].evaluate(np.empty((1, 0)))[0]),)

    def weights(self, path: Call) -> tuple[float, ...]:
        """Return 1 / T."""
        (relaxation_time,) = self.numbers(path)
        return (1.0 / relaxation_time,)

    def numbers_from(self, weights: np.ndarray) -> tuple[float, ...]:
        """Return T from 1 / T."""
        return (1.0 / float(weights[0]),)

    def parts(self, path: Call, states: Sequence[Sum]) -> tuple[Sum, ...]:
        """Return what 1 / T multiplies in the rate of h."""
        return (self.term(path, states),)

    def term(self, path: Call, states: Sequence[Sum]) -> Sum:
        """Return d."""
        return sub(path.args[0], states[0])

    def rests(self, path: Call) -> tuple[Sum, ...]:
        """Return h in balance."""
        return path.args[:1]

    def fades(self, path: Call) -> float:
        """Return some relaxation times."""
        return FADED * self.numbers(path)[0]

    def said(self, path: Call, sure: Sequence[str]) -> str:
        """Return the relaxation time in words."""
        return f"relaxation time {self.numbers(path)[0]:.4g}{sure[0]}"

    def along(
        self, path: Call, rows: np.ndarray, starts: Sequence[float] | None = None
    ) -> np.ndarray:
        """Return h on rows of a record, from its value on the first one; by default in balance."""
        x, t = (argument.evaluate(rows) for argument in path.args[:2])
        begun = 0.0 if starts is None else float(x[0]) - starts[0]
        return (x - relaxing_along(x, t, *self.numbers(path), begun))[:, None]

    def spans(self, path: Call, rows: np.ndarray) -> list[tuple[float, float]]:
        """Return between which values h may have begun: those of x here, and as far beyond."""
        return [span_of(path.args[0].evaluate(rows))]
