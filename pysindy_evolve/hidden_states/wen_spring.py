r"""Bouc and Wen's hysteresis of a spring, which loses energy but does not yield.

A hidden state w follows the velocity v of a position x,

    w' = (v - beta |v| w - gamma v |w|) / L,    gamma = beta - 1.

Where the motion has turned and w still points the other way, its slope is 1 + |w|; where w leads,
it is 1 - (2 beta - 1) |w|. With beta = 1 it is Dahl's friction, with 1/2 its slope is always 1 on
the way out, and below it grows steeper: a joint, a rubber mount or a wall that stiffens. The
friction that runs to 1, see boucwen.py, is the same with other numbers where beta is over 1/2; here
they may pass that limit, where a friction would need a length without end.

References
----------
Wen, J. Eng. Mech. Div. ASCE 102 (1976), 249-263. Noel, Schoukens, "Hysteretic benchmark with a
dynamic nonlinearity" (2016), https://www.nonlinearbenchmark.org, for one that stiffens.
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

__all__ = ["WEN_SPRING", "SpringHysteresis", "springing", "springing_along"]

SUFFIX = "hyst"  # what the name of the hidden state ends in, after that of the position
LOSSES = (0.02, 1.0)  # beta, when fitted: beyond, hardly any is lost, or it is a friction
WIDER = 2.0  # times by which w may have been larger before a record


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
        w where the path begins.

    Returns
    -------
    ndarray of shape (n_samples,)
    """
    return turning_along(x / length, 2.0 * loss - 1.0, 1.0, start)


def _on_rows(x: np.ndarray, v: np.ndarray, length: np.ndarray, loss: np.ndarray) -> np.ndarray:
    return springing_along(x, float(length[0]), float(loss[0]))


def _state(x: Any, *_: Any) -> Any:
    return sympy.Symbol(f"{x}_{SUFFIX}", real=True)


# Of position, velocity, L and beta. The velocity only says what the hidden state is driven by.
WEN_SPRING = Operator("bouc_wen_spring", _on_rows, 4, _state)


def springing(x: Sum, v: Sum, length: float, loss: float) -> Sum:
    """Return w as a term of a position and its velocity."""
    return call(WEN_SPRING, x, v, constant(length), constant(loss))


class SpringHysteresis(Hysteresis):
    """What a model needs to know of w; see `PathKind`."""

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
        """Return what 1 / L and beta / L multiply in the rate of w."""
        v, state = path.args[1], states[0]
        held = mul(call(BUILTIN["abs"], v), state)
        led = mul(v, call(BUILTIN["abs"], state))
        return add(v, led), sub(constant(0.0), add(held, led))

    def said(self, path: Call, sure: Sequence[str]) -> str:
        """Return length and loss in words."""
        length, loss = self.numbers(path)
        way = "stiffer" if loss < 0.5 else "softer"
        turns = f"forgets a turn over a length of {length:.4g}{sure[0]}"
        return f"{turns}, grows {way} on the way out, beta = {loss:.3g}{sure[1]}"

    def spans(self, path: Call, rows: np.ndarray) -> list[tuple[float, float]]:
        """Return between which values w may have begun: those of these rows, and beyond."""
        largest = WIDER * float(np.max(np.abs(self.along(path, rows))))
        return [(-largest, largest)]
