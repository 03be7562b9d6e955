"""A delay and a lag one after the other, as of a process with dead time and of its actuator.

Whichever of the two is found first stands for both, and is as long as both together. The other one
can then only come in if the first gives way to it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import CubicSpline

from ...hidden_states.memory import DELAY, LAG, Memory
from ..evidence.findings import Finding, MemoryFinding

__all__ = ["Chain", "Traded", "chains_in", "traded", "untraded"]

MOST = 0.95  # of a memory, that may give way to another one


@dataclass(frozen=True)
class Traded(Memory):
    """A memory of an input that has the other kind already, which gives way to it."""

    present: float = np.inf  # delay or time constant that it has
    given: float = 0.0  # how much of that it gives up

    @property
    def leaves_some(self) -> bool:
        """Whether the other memory does not give up all of itself."""
        return self.given <= MOST * self.present

    def response(self, t: np.ndarray, u: np.ndarray) -> np.ndarray:
        """Return what acts, of an input that has passed the other memory; as it is if too short."""
        (value,) = self.values
        left = self.present - self.given
        if not self.leaves_some or np.ptp(u) == 0.0:
            return u
        if self.kind == LAG:
            early = np.asarray(CubicSpline(t, u)(np.minimum(t + self.given, t[-1])))
            return Memory(LAG, self.column, (value,)).response(t, early)
        # A lag of T and one of a after it, taken back by T: that leaves a alone.
        both = Memory(LAG, self.column, (left,)).response(t, u)
        shorter = both + self.present / left * (u - both)
        return Memory(DELAY, self.column, (value,)).response(t, shorter)


@dataclass(frozen=True)
class Chain(Memory):
    """A delay and a lag after it, or a lag and a delay: what comes out is the same."""

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


def traded(memory: Memory, present: Sequence[Memory]) -> Memory:
    """Return a delay or lag for which the other one gives way, by as much as it delays on average.

    Parameters
    ----------
    memory : Memory
        To be tried.
    present : sequence of Memory
        Memories that the inputs have already.

    Returns
    -------
    Memory
        As it is, unless its input has one other memory, of the other kind, that is longer.
    """
    others = [one for one in present if one.column == memory.column]
    if len(others) != 1 or {memory.kind, others[0].kind} != {DELAY, LAG}:
        return memory
    longest = others[0].values[0]
    if memory.values[0] > MOST * longest:
        return memory
    return Traded(memory.kind, memory.column, memory.values, longest, memory.values[0])


def untraded(findings: Sequence[Finding]) -> list[Finding]:
    """Return findings in which each memory is as long as it is, where one gave way to another.

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
                left = (other.memory.values[0] - finding.memory.given,)
                found[k] = replace(other, memory=replace(other.memory, values=left))
    return found
