"""A delay and a lag in series at one input, as of a process with dead time and its actuator.

Whichever is found first is tuned to the length of both. The other one can then enter only if the
first is shortened in exchange: a trade.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import CubicSpline

from ...hidden_states.memory import DELAY, LAG, Memory
from ..evidence.findings import Finding, MemoryFinding

MAX_TRADED_SHARE = 0.95  # largest share of a memory that may be traded for another one


@dataclass(frozen=True)
class Traded(Memory):
    """A memory in exchange for which another one of its input, of the other kind, is shortened."""

    present: float = np.inf  # delay or time constant of the other memory
    given: float = 0.0  # by how much that one is shortened

    @property
    def leaves_some(self) -> bool:
        """Whether a notable part of the other memory is left."""
        return self.given <= MAX_TRADED_SHARE * self.present

    def response(self, t: np.ndarray, u: np.ndarray) -> np.ndarray:
        """Return what acts, from an input behind the whole other memory; `u` if none is left."""
        (value,) = self.values
        shortened = self.present - self.given
        if not self.leaves_some or np.ptp(u) == 0.0:
            return u
        if self.kind == LAG:
            early = np.asarray(CubicSpline(t, u)(np.minimum(t + self.given, t[-1])))
            return Memory(LAG, self.column, (value,)).response(t, early)
        # Undo the lag of T = present, after one more of a = shortened: a w' = u - w for w = lagged,
        # and w + T w' is the input behind a lag of a alone.
        lagged = Memory(LAG, self.column, (shortened,)).response(t, u)
        behind_short_lag = lagged + self.present / shortened * (u - lagged)
        return Memory(DELAY, self.column, (value,)).response(t, behind_short_lag)


@dataclass(frozen=True)
class Chain(Memory):
    """A delay and a lag in series, in either order."""

    def response(self, t: np.ndarray, u: np.ndarray) -> np.ndarray:
        """Return what acts."""
        delay, time_constant = self.values
        late = Memory(DELAY, self.column, (delay,)).response(t, u)
        return Memory(LAG, self.column, (time_constant,)).response(t, late)


def chains_in(findings: Sequence[Finding]) -> list[tuple[MemoryFinding, MemoryFinding]]:
    """Return the delay and the lag of each input that has both."""
    found = {(f.memory.column, f.memory.kind): f for f in findings if isinstance(f, MemoryFinding)}
    return [
        (finding, found[column, LAG])
        for (column, kind), finding in found.items()
        if kind == DELAY and (column, LAG) in found
    ]


def with_trade(memory: Memory, present: Sequence[Memory]) -> Memory:
    """Return a delay or lag in exchange for which the other one is shortened by as much.

    Parameters
    ----------
    memory : Memory
        To be tried.
    present : sequence of Memory
        Memories that the inputs have already.

    Returns
    -------
    Memory
        As it is, unless its input has exactly one other memory, of the other kind, that is longer.
    """
    others = [m for m in present if m.column == memory.column]
    if len(others) != 1 or {memory.kind, others[0].kind} != {DELAY, LAG}:
        return memory
    present_value = others[0].values[0]
    if memory.values[0] > MAX_TRADED_SHARE * present_value:
        return memory
    return Traded(memory.kind, memory.column, memory.values, present_value, memory.values[0])


def with_trades_done(findings: Sequence[Finding]) -> list[Finding]:
    """Return findings with all trades done: the other memories shortened, the new ones plain.

    Parameters
    ----------
    findings : sequence of Finding
        In the order in which memories are applied.

    Returns
    -------
    list of Finding
    """
    found = list(findings)
    for place, finding in enumerate(findings):
        if not isinstance(finding, MemoryFinding) or not isinstance(finding.memory, Traded):
            continue
        kind, column, values = finding.memory.kind, finding.memory.column, finding.memory.values
        found[place] = replace(finding, memory=Memory(kind, column, values))
        for k, other in enumerate(found[:place]):
            if isinstance(other, MemoryFinding) and other.memory.column == column:
                shortened = (other.memory.values[0] - finding.memory.given,)
                found[k] = replace(other, memory=replace(other.memory, values=shortened))
    return found
