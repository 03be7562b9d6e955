r"""Memory of an input: what it goes through before it acts, given as what comes out.

===================  ==============================================  =====================
kind                 hidden state w                                  what acts
===================  ==============================================  =====================
``"input delay"``    none                                            u(t - d)
``"actuator lag"``   T w' = u - w                                    w
``"hidden state"``   T w' = u - sqrt(w), a vessel that runs out      sqrt(w)
the same, with brim  T w' = u - sqrt(w) - o, o = 100 max(w - b, 0)   sqrt(w) + s o
===================  ==============================================  =====================

What rises above the brim b of a vessel runs over in a hundredth of its time constant, and the share
s of it arrives where the outlet leads.

Each has the gain one, so the coefficients of a model keep their meaning. Before a record begins,
the input is taken to have stood still at its first value, and the hidden state to be in balance;
`preceded` puts another value there.
A memory changes the inputs of a record and nothing else: whatever works on records works on these.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.signal import lfilter

from ..operators import BUILTIN
from ..terms import Sum, add, call, constant, mul, power, sub

if TYPE_CHECKING:
    from ..signals import Record

__all__ = ["DELAY", "LAG", "VESSEL", "Memory", "acting", "balance", "preceded", "rate"]
__all__ += ["remembered"]

DELAY, LAG, VESSEL = "input delay", "actuator lag", "hidden state"
REFINEMENT = 4  # steps in each sample of a lag's input, straight within them
N_SUBSTEPS = 4  # of a vessel, in each sample
OVERFLOW = 100.0  # rate at which a vessel runs over, in units of 1/T


@dataclass(frozen=True)
class Memory:
    """What one input goes through before it acts.

    Attributes
    ----------
    kind : {"input delay", "actuator lag", "hidden state"}
        Name of the effect.
    column : int
        Which input.
    values : tuple of float
        Delay or time constant, units of t; of a vessel with a brim also its height, in squared
        units of u, and the share of what runs over that arrives.
    """

    kind: str
    column: int
    values: tuple[float, ...]

    def response(self, t: np.ndarray, u: np.ndarray) -> np.ndarray:
        """Return what acts.

        Parameters
        ----------
        t : ndarray of shape (n_samples,)
            Uniform times.
        u : ndarray of shape (n_samples,)
            The input.

        Returns
        -------
        ndarray of shape (n_samples,)
        """
        if np.ptp(u) == 0.0:
            return u
        return _RESPONSES[self.kind](t, u, *self.values)

    def apply(self, record: Record) -> Record:
        """Return a record whose input is what acts, in its raw data as well."""
        return record.with_inputs(self._on)

    def _on(self, t: np.ndarray, u: np.ndarray) -> np.ndarray:
        changed = np.array(u)
        changed[:, self.column] = self.response(t, u[:, self.column])
        return changed

    def state(self, record: Record) -> np.ndarray:
        """Return the hidden state on a record whose input has not passed the memory yet."""
        inner = replace(self, values=(*self.values[:2], 0.0)) if self.has_brim else self
        acts = inner.apply(record).u
        column = np.zeros(len(record)) if acts is None else acts[:, self.column]
        return column**2 if self.kind == VESSEL else column

    @property
    def has_brim(self) -> bool:
        """Whether it is a vessel that can run over."""
        return len(self.values) > 1

    @property
    def quantities(self) -> tuple[str, ...]:
        """What its values are."""
        first = "delay" if self.kind == DELAY else "time constant"
        return (first, "brim", "share of the overflow that arrives")[: len(self.values)]

    @property
    def suffix(self) -> str:
        """What the name of the hidden state ends in."""
        return "level" if self.kind == VESSEL else "lag"

    @property
    def has_state(self) -> bool:
        """Whether a hidden state belongs to it."""
        return self.kind != DELAY


def remembered(record: Record, memories: Sequence[Memory]) -> Record:
    """Apply memories to a record, one after the other."""
    for memory in memories:
        record = memory.apply(record)
    return record


def preceded(record: Record, past: Sequence[float]) -> Record:
    """Return a record before which the inputs stood at other values than their first ones.

    The first raw sample of an input stands for all that came before it.
    """
    made, changed = record.preparation, record.raw_u.copy()
    changed[0] = past
    if made is None or not record.has_raw_inputs:
        return replace(record, u=changed)
    return replace(record, preparation=replace(made, u=changed))


def rate(memory: Memory, state: Sum, source: Sum) -> Sum:
    """Return the right-hand side of a hidden state, from the state and what it is fed by."""
    leaving = add(_outflow(memory, state), _overflow(memory, state))
    return mul(constant(1.0 / memory.values[0]), sub(source, leaving))


def acting(memory: Memory, state: Sum) -> Sum:
    """Return what acts, from the hidden state."""
    arriving = memory.values[2] if memory.has_brim else 0.0
    return add(_outflow(memory, state), mul(constant(arriving), _overflow(memory, state)))


def _outflow(memory: Memory, state: Sum) -> Sum:
    return call(BUILTIN["sqrt"], state) if memory.kind == VESSEL else state


def _overflow(memory: Memory, state: Sum) -> Sum:
    """Return 100 max(w - b, 0)."""
    if not memory.has_brim:
        return constant(0.0)
    above = sub(state, constant(memory.values[1]))
    return mul(constant(0.5 * OVERFLOW), add(above, call(BUILTIN["abs"], above)))


def balance(memory: Memory, source: Sum) -> Sum:
    """Return the value of the hidden state at which it does not change."""
    if memory.kind != VESSEL:
        return source
    level = power(source, 2)
    if not memory.has_brim:
        return level
    above = sub(level, constant(memory.values[1]))  # no further than the brim
    return sub(level, mul(constant(0.5), add(above, call(BUILTIN["abs"], above))))


def _delayed(t: np.ndarray, u: np.ndarray, delay: float) -> np.ndarray:
    """Return u(t - delay), by splines between the samples."""
    return np.asarray(CubicSpline(t, u)(np.maximum(t - delay, t[0])))


def _lagging(t: np.ndarray, u: np.ndarray, time_constant: float) -> np.ndarray:
    """Return w of T w' = u - w for an input that is smooth between samples, by splines."""
    fine = np.linspace(t[0], t[-1], REFINEMENT * (len(t) - 1) + 1)
    smooth = CubicSpline(t, u)(fine)
    ratio = float(t[-1] - t[0]) / (len(fine) - 1) / time_constant
    decay = np.exp(-ratio)
    new = 1.0 + np.expm1(-ratio) / ratio
    old = 1.0 - decay - new
    driven = lfilter([new, old], [1.0, -decay], smooth - u[0])  # exact for what is straight
    return np.asarray(u[0] + driven[::REFINEMENT])


def _running_out(
    t: np.ndarray, u: np.ndarray, time_constant: float, brim: float = np.inf, share: float = 0.0
) -> np.ndarray:
    """Return sqrt(w) + s o of T w' = u - sqrt(w) - o, where the input is not negative."""
    n = len(t)
    fine = np.interp((np.arange(N_SUBSTEPS * (n - 1)) + 0.5) / N_SUBSTEPS, np.arange(n), u)
    ratio = float(t[-1] - t[0]) / (n - 1) / N_SUBSTEPS / time_constant
    out = np.empty(N_SUBSTEPS * (n - 1) + 1)
    level = min(max(float(u[0]), 0.0) ** 2, brim)
    out[0] = np.sqrt(level)
    for i, inflow in enumerate(fine.tolist()):
        # Implicit in what leaves, which follows from the root s of s^2 + ratio s = level.
        level += ratio * inflow
        root = _root(level, ratio)
        over = 0.0
        if root * root > brim:
            stiff = 1.0 + ratio * OVERFLOW
            root = _root((level + ratio * OVERFLOW * brim) / stiff, ratio / stiff)
            over = OVERFLOW * (root * root - brim)
        level = root * root
        out[i + 1] = root + share * over
    return out[::N_SUBSTEPS]


def _root(level: float, ratio: float) -> float:
    """Return the root s of s^2 + ratio s = level."""
    half = 0.5 * ratio
    return math.sqrt(max(level, 0.0) + half * half) - half


_RESPONSES: dict[str, Callable[..., np.ndarray]] = {
    DELAY: _delayed,
    LAG: _lagging,
    VESSEL: _running_out,
}
