r"""Memories of an input: a delay, a lag or a vessel between the input and its effect.

===================  ==============================================  =====================
kind                 hidden state w                                  output, which acts
===================  ==============================================  =====================
``"input delay"``    none                                            u(t - d)
``"actuator lag"``   T w' = u - w                                    w
``"hidden state"``   T w' = u - sqrt(w), a draining vessel           sqrt(w)
the same, with brim  T w' = u - sqrt(w) - o, o = 100 max(w - b, 0)   sqrt(w) + s o
===================  ==============================================  =====================

Above the brim b a vessel overflows, with a hundredth of its time constant. A share s of the
overflow arrives where the outlet leads.

The static gain is one below a brim, so the coefficients of a model keep their meaning. Before a
record begins, the input is taken as constant at its first value, with the hidden state in balance;
`with_past_inputs` puts another value there. A memory changes only the inputs of a record, so any
function of a record works on the result.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.signal import lfilter

from ..operators import BUILTIN
from ..terms import Sum, add, call, constant, mul, power, sub

if TYPE_CHECKING:
    from ..signals import Record

DELAY, LAG, VESSEL = "input delay", "actuator lag", "hidden state"
REFINEMENT = 4  # steps per sample for a lag; the input is straight within each
N_SUBSTEPS = 4  # integration steps per sample for a vessel
OVERFLOW = 100.0  # rate of overflow above the brim, in units of 1/T


@dataclass(frozen=True)
class Memory:
    """A delay, lag or vessel between one input and its effect.

    Attributes
    ----------
    kind : {"input delay", "actuator lag", "hidden state"}
        Name of the effect.
    column : int
        Column of the input.
    values : tuple of float
        Delay or time constant, units of t. For a vessel with a brim also the height of the brim, in
        squared units of u, and the share of the overflow that arrives.
    """

    kind: str
    column: int
    values: tuple[float, ...]

    def response(self, t: np.ndarray, u: np.ndarray) -> np.ndarray:
        """Return the output of the memory.

        Parameters
        ----------
        t : ndarray of shape (n_samples,)
            Uniform times.
        u : ndarray of shape (n_samples,)
            The input.

        Returns
        -------
        ndarray of shape (n_samples,)
            Units of u.
        """
        if np.ptp(u) == 0.0:
            return u
        return _RESPONSES[self.kind](t, u, *self.values)

    def apply(self, record: Record) -> Record:
        """Return a record with the output in place of the input, in its raw data as well."""
        return record.with_inputs(self._on)

    def _on(self, t: np.ndarray, u: np.ndarray) -> np.ndarray:
        inputs = np.array(u)
        inputs[:, self.column] = self.response(t, u[:, self.column])
        return inputs

    def state(self, record: Record) -> np.ndarray:
        """Return the hidden state, (n_samples,), on a record to which the memory is not applied."""
        without_overflow = replace(self, values=(*self.values[:2], 0.0)) if self.has_brim else self
        response = without_overflow.apply(record).u
        column = np.zeros(len(record)) if response is None else response[:, self.column]
        return column**2 if self.kind == VESSEL else column

    @property
    def has_brim(self) -> bool:
        """Whether it is a vessel that can overflow."""
        return len(self.values) > 1

    @property
    def quantities(self) -> tuple[str, ...]:
        """Names of its values."""
        first = "delay" if self.kind == DELAY else "time constant"
        return (first, "brim", "share of the overflow that arrives")[: len(self.values)]

    @property
    def suffix(self) -> str:
        """Suffix of the name of the hidden state: that of u is u_level or u_lag."""
        return "level" if self.kind == VESSEL else "lag"

    @property
    def has_state(self) -> bool:
        """Whether it has a hidden state."""
        return self.kind != DELAY


def with_memories_applied(record: Record, memories: Sequence[Memory]) -> Record:
    """Return a record with memories applied to its inputs, one after the other."""
    for memory in memories:
        record = memory.apply(record)
    return record


def all_with_memories(records: Iterable[Record], memories: Sequence[Memory]) -> list[Record]:
    """Return records with memories applied to the inputs of each."""
    return [with_memories_applied(record, memories) for record in records]


def with_past_inputs(record: Record, past: Sequence[float]) -> Record:
    """Return a record before which the inputs were constant at other values than their first ones.

    These replace the first raw sample, whose value a memory takes for the time before the record.
    """
    preparation, changed = record.preparation, record.raw_u.copy()
    changed[0] = past
    if preparation is None or not record.has_raw_inputs:
        return replace(record, u=changed)
    return replace(record, preparation=replace(preparation, u=changed))


def rate(memory: Memory, state: Sum, source: Sum) -> Sum:
    """Return the right-hand side of a hidden state that a source feeds."""
    leaving = add(_outflow(memory, state), _overflow(memory, state))
    return mul(constant(1.0 / memory.values[0]), sub(source, leaving))


def output_of(memory: Memory, state: Sum) -> Sum:
    """Return the output of a memory as an expression of its hidden state."""
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
    """Return the hidden state in balance with a source; that of a vessel is cut at its brim."""
    if memory.kind != VESSEL:
        return source
    level = power(source, 2)
    if not memory.has_brim:
        return level
    above = sub(level, constant(memory.values[1]))  # level - max(above, 0) = min(level, brim)
    return sub(level, mul(constant(0.5), add(above, call(BUILTIN["abs"], above))))


def _delayed(t: np.ndarray, u: np.ndarray, delay: float) -> np.ndarray:
    """Return u(t - delay), with cubic splines between the samples."""
    return np.asarray(CubicSpline(t, u)(np.maximum(t - delay, t[0])))


def _lagging(t: np.ndarray, u: np.ndarray, time_constant: float) -> np.ndarray:
    """Return w of T w' = u - w, with the input a cubic spline between the samples."""
    fine_t = np.linspace(t[0], t[-1], REFINEMENT * (len(t) - 1) + 1)
    fine_u = CubicSpline(t, u)(fine_t)
    step = float(t[-1] - t[0]) / (len(fine_t) - 1) / time_constant
    decay = np.exp(-step)
    weight_new = 1.0 + np.expm1(-step) / step
    weight_old = 1.0 - decay - weight_new
    # Exact where the input is straight within each step.
    deviation = lfilter([weight_new, weight_old], [1.0, -decay], fine_u - u[0])
    return np.asarray(u[0] + deviation[::REFINEMENT])


def _running_out(
    t: np.ndarray, u: np.ndarray, time_constant: float, brim: float = np.inf, share: float = 0.0
) -> np.ndarray:
    """Return sqrt(w) + s o of T w' = u - sqrt(w) - o, for an input that is not negative."""
    n = len(t)
    inflows = np.interp((np.arange(N_SUBSTEPS * (n - 1)) + 0.5) / N_SUBSTEPS, np.arange(n), u)
    step = float(t[-1] - t[0]) / (n - 1) / N_SUBSTEPS / time_constant
    out = np.empty(N_SUBSTEPS * (n - 1) + 1)
    level = min(max(float(u[0]), 0.0) ** 2, brim)
    out[0] = np.sqrt(level)
    for i, inflow in enumerate(inflows.tolist()):
        # Implicit Euler step for the outflow: the new sqrt(w) solves s^2 + step s = level.
        level += step * inflow
        root = _root(level, step)
        overflow = 0.0
        if root * root > brim:
            stiff = 1.0 + step * OVERFLOW
            root = _root((level + step * OVERFLOW * brim) / stiff, step / stiff)
            overflow = OVERFLOW * (root * root - brim)
        level = root * root
        out[i + 1] = root + share * overflow
    return out[::N_SUBSTEPS]


def _root(level: float, step: float) -> float:
    """Return the root s of s^2 + step s = level."""
    half = 0.5 * step
    return math.sqrt(max(level, 0.0) + half * half) - half


_RESPONSES: dict[str, Callable[..., np.ndarray]] = {
    DELAY: _delayed,
    LAG: _lagging,
    VESSEL: _running_out,
}
