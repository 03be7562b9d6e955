r"""Bouc and Wen's hysteresis: a friction that depends on the path of the motion.

A hidden state w follows the velocity v of a position x,

    w' = (v - beta |v| w - gamma v |w|) / L,    beta + gamma = 1,

and runs to 1 where x goes up, to -1 where it goes down, over about the length L. Its slope there is
(1 - |w|) / L. Where the motion has turned and w still has the old sign, the slope is
(1 + k |w|) / L, with the rate of unloading k = beta - gamma: 1 for Dahl's friction, near 0 for a
straight line.

As w depends on the path of x but not on its speed, it is an operator on the rows of a record in
time order, and enters a model like any other term. It is exact for a path that is straight between
samples.

References
----------
Wen, J. Eng. Mech. Div. ASCE 102 (1976), 249-263. Ismail, Ikhouane, Rodellar, Arch. Comput. Methods
Eng. 16 (2009), DOI 10.1007/s11831-009-9031-8: the meaning of its parameters.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, ClassVar

import numpy as np
import sympy

from ..operators import BUILTIN, Operator
from ..terms import Call, Sum, add, call, constant, mul, sub, value_of
from .turning import turning_along

SUFFIX = "yield"  # the hidden state of q is named q_yield
RATES = (0.05, 20.0)  # range of k when it is fitted; values beyond an end cannot be told apart


def yielding_along(
    x: np.ndarray, length: float, unloading: float, start: float = 0.0
) -> np.ndarray:
    """Return w along a path.

    Parameters
    ----------
    x : ndarray of shape (n_samples,)
        Positions in time order.
    length : float
        L, units of x.
    unloading : float
        k, dimensionless, positive.
    start : float
        w on the first row, between -1 and 1.

    Returns
    -------
    ndarray of shape (n_samples,)
    """
    return turning_along(x / length, 1.0, unloading, start)


def _on_rows(x: np.ndarray, v: np.ndarray, length: np.ndarray, unloading: np.ndarray) -> np.ndarray:
    return yielding_along(x, float(length[0]), float(unloading[0]))


def _state(x: Any, *_: Any) -> Any:
    return sympy.Symbol(f"{x}_{SUFFIX}", real=True)


# Arguments: position, velocity, L and k. The velocity serves only the equation of the hidden state.
BOUC_WEN = Operator("bouc_wen", _on_rows, 4, _state)


def yielding(x: Sum, v: Sum, length: float, unloading: float) -> Sum:
    """Return w as a term of a position and its velocity."""
    return call(BOUC_WEN, x, v, constant(length), constant(unloading))


class Hysteresis:
    """Bouc-Wen friction as a `PathKind`."""

    suffix = SUFFIX
    order = 1
    follow: ClassVar[Callable[..., np.ndarray]] = staticmethod(yielding_along)

    def numbers(self, path: Call) -> tuple[float, float]:
        """Return L and k."""
        length, unloading = map(value_of, path.args[2:])
        return length, unloading

    def weights(self, path: Call) -> tuple[float, ...]:
        """Return 1 / L and k / L."""
        length, unloading = self.numbers(path)
        return 1.0 / length, unloading / length

    def numbers_from(self, weights: np.ndarray) -> tuple[float, ...]:
        """Return L and k from 1 / L and k / L."""
        unloading = float(np.clip(weights[1] / weights[0], *RATES))
        return 1.0 / float(weights[0]), unloading

    def parts(self, path: Call, states: Sequence[Sum]) -> tuple[Sum, ...]:
        """Return the expressions that 1 / L and k / L multiply in the rate of w."""
        v, state = path.args[1], states[0]
        half, magnitude, speed = constant(0.5), call(BUILTIN["abs"], state), call(BUILTIN["abs"], v)
        by_speed, by_velocity = mul(half, mul(speed, state)), mul(half, mul(v, magnitude))
        return sub(v, add(by_speed, by_velocity)), sub(by_velocity, by_speed)

    def term(self, path: Call, states: Sequence[Sum]) -> Sum:
        """Return w itself."""
        return states[0]

    def rests(self, path: Call) -> tuple[Sum, ...]:
        """Return zero."""
        return (constant(0.0),)

    def fades(self, path: Call) -> float:
        """Return zero: the initial value fades over a length of path, not over a time."""
        return 0.0

    def describe(self, path: Call, sure: Sequence[str]) -> str:
        """Return length and rate of unloading in words."""
        length, unloading = self.numbers(path)
        text = f"builds up over a length of {length:.4g}{sure[0]}"
        return f"{text}, unloads {unloading:.3g} times as fast{sure[1]}"

    def along(
        self, path: Call, rows: np.ndarray, starts: Sequence[float] | None = None
    ) -> np.ndarray:
        """Return w on rows of a record, starting from a value on the first row, zero by default."""
        start = 0.0 if starts is None else starts[0]
        return self.follow(path.args[0].evaluate(rows), *self.numbers(path), start)[:, None]

    def spans(self, path: Call, rows: np.ndarray) -> list[tuple[float, float]]:
        """Return the range of w on the first row."""
        return [(-1.0, 1.0)]
