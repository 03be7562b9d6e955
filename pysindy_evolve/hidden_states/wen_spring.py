r"""Bouc and Wen's hysteresis of a spring, which loses energy but does not yield.

A hidden state w follows the velocity v of a position x,

    w' = (v - beta |v| w - gamma v |w|) / L,    gamma = beta - 1.

Where the motion has turned and w still has the old sign, its slope is (1 + |w|) / L; where w leads,
it is (1 - (2 beta - 1) |w|) / L. With beta = 1 it is Dahl's friction. With beta = 1/2 the slope is
constant on the way out. Below 1/2 it grows: a joint, a rubber mount or a wall that stiffens. For
beta above 1/2 it is the friction of boucwen.py in other parameters; at 1/2 and below, that friction
would need an infinite length.

References
----------
Wen, J. Eng. Mech. Div. ASCE 102 (1976), 249-263. Noel, Schoukens, "Hysteretic benchmark with a
dynamic nonlinearity" (2016), https://www.nonlinearbenchmark.org: a stiffening one.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, ClassVar

import numpy as np
import sympy

from ..operators import BUILTIN, Operator
from ..terms import Call, Sum, add, call, constant, mul, sub
from .boucwen import Hysteresis
from .turning import turning_along

SUFFIX = "hyst"  # the hidden state of q is named q_hyst
LOSSES = (0.02, 1.0)  # range of beta when it is fitted: below, no loss to speak of; above, friction
WIDER = 2.0  # largest |w| on the first row, over the largest in the record


def springing_along(x: np.ndarray, length: float, loss: float, start: float = 0.0) -> np.ndarray:
    """Return w along a path.

    Parameters
    ----------
    x : ndarray of shape (n_samples,)
        Positions in time order.
    length : float
        L, units of x.
    loss : float
        beta, dimensionless, positive.
    start : float
        w on the first row.

    Returns
    -------
    ndarray of shape (n_samples,)
    """
    return turning_along(x / length, 2.0 * loss - 1.0, 1.0, start)


def _on_rows(x: np.ndarray, v: np.ndarray, length: np.ndarray, loss: np.ndarray) -> np.ndarray:
    return springing_along(x, float(length[0]), float(loss[0]))


def _state(x: Any, *_: Any) -> Any:
    return sympy.Symbol(f"{x}_{SUFFIX}", real=True)


# Arguments: position, velocity, L and beta. The velocity serves only the hidden state's equation.
WEN_SPRING = Operator("bouc_wen_spring", _on_rows, 4, _state)


def springing(x: Sum, v: Sum, length: float, loss: float) -> Sum:
    """Return w as a term of a position and its velocity."""
    return call(WEN_SPRING, x, v, constant(length), constant(loss))


class SpringHysteresis(Hysteresis):
    """Bouc-Wen spring as a `PathKind`."""

    suffix = SUFFIX
    follow: ClassVar[Callable[..., np.ndarray]] = staticmethod(springing_along)

    def weights(self, path: Call) -> tuple[float, ...]:
        """Return 1 / L and beta / L."""
        length, loss = self.numbers(path)
        return 1.0 / length, loss / length

    def numbers_from(self, weights: np.ndarray) -> tuple[float, ...]:
        """Return L and beta from 1 / L and beta / L."""
        return 1.0 / float(weights[0]), float(np.clip(weights[1] / weights[0], *LOSSES))

    def parts(self, path: Call, states: Sequence[Sum]) -> tuple[Sum, ...]:
        """Return the expressions that 1 / L and beta / L multiply in the rate of w."""
        v, state = path.args[1], states[0]
        by_speed = mul(call(BUILTIN["abs"], v), state)
        by_velocity = mul(v, call(BUILTIN["abs"], state))
        return add(v, by_velocity), sub(constant(0.0), add(by_speed, by_velocity))

    def describe(self, path: Call, sure: Sequence[str]) -> str:
        """Return length and loss in words."""
        length, loss = self.numbers(path)
        change = "stiffer" if loss < 0.5 else "softer"
        text = f"forgets a turn over a length of {length:.4g}{sure[0]}"
        return f"{text}, grows {change} on the way out, beta = {loss:.3g}{sure[1]}"

    def spans(self, path: Call, rows: np.ndarray) -> list[tuple[float, float]]:
        """Return the range of w on the first row: twice the largest |w| of these rows."""
        largest = WIDER * float(np.max(np.abs(self.along(path, rows))))
        return [(-largest, largest)]
