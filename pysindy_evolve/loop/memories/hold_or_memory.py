"""Whether an input is held between its samples, which is how it was recorded, and no effect.

Where an input jumps in one step, the record itself shows that it is held, but not when in that step
it jumps: it may follow a controller, and begin at the sample, or somebody's hand. So if such an
input is found to act late by less than that, it is no delay of the machine: it begins at the
sample, if that does as well. If it is late by more, or lags, it is held first and late after that,
unless that does worse. One that moves with every sample as if at random may be a controller's
answer to noise, which is held as well, if the model does better so. What is missing may hide that.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...hidden_states.memory import DELAY, Memory
from ...signals import Record
from ...signals.zero_order_hold import HALF
from ..effects.candidate import Candidate
from ..evidence.scoring import LEAD, MARGIN, propose, quick_fit, score
from ..given.design import Design
from ..given.input_errors import jumps_at_once, may_be_held, may_be_steps
from ..given.segments import Segments, segments
from .reach import exchanged, plainest, reach_of

__all__ = [
    "free_to_be_held",
    "hold_beside_another",
    "holds_alone",
    "in_pieces",
    "memory_beside_hold",
]

EVEN = 0.01  # of a sampling time, by which those of records that are sampled alike may differ
SHORTEST, LONGEST = 0.4, 0.6  # the same, of a hold that a user's own low-pass has hidden
LATEST = 0.6  # sampling times: a hold is late by half of one, and a delay is not known exactly


@dataclass(frozen=True)
class _Hold(Memory):
    """That an input is held from each sample to the next, if it jumps, and no memory beside it."""

    def response(self, t: np.ndarray, u: np.ndarray) -> np.ndarray:
        return _held(t, u, self.column)


@dataclass(frozen=True)
class _BehindHold(Memory):
    """A memory of an input that is held from each sample to the next, if it jumps."""

    def response(self, t: np.ndarray, u: np.ndarray) -> np.ndarray:
        return super().response(t, _held(t, u, self.column))


def _held(t: np.ndarray, u: np.ndarray, column: int) -> np.ndarray:
    if not may_be_steps(u):
        return u
    return Memory(DELAY, column, (HALF * float(t[1] - t[0]),)).response(t, u)


def _may_be_hold(memory: Memory, records: Sequence[Record]) -> bool:
    """Tell whether it is as short as a hold, in records whose raw inputs nobody knows."""
    shares = [memory.values[0] / record.dt for record in records]
    unknown = all(record.preparation is None for record in records)
    return unknown and all(SHORTEST < share < LONGEST for share in shares)


def holds_alone(design: Design, part: Segments) -> dict[int, float]:
    """Return which inputs explain more if they are held, where nothing else is looked for.

    Parameters
    ----------
    design : Design
        The model.
    part : Segments
        Pieces of the training records.

    Returns
    -------
    dict of int to float
        Inputs that may be held in all records, none of them known as such, and how late each is, in
        sampling times.
    """
    free = free_to_be_held(part.records)
    gains = _gains(free, design, in_pieces(part)) if free else []
    return {column: HALF for column, gain in zip(free, gains, strict=True) if gain > MARGIN}


def hold_beside_another(column: int, design: Design, part: Segments, held: Segments) -> bool:
    """Tell whether an input explains more if it is held, beside what seems to be missing most then.

    A hold and an effect may hide each other: the answer of a controller that comes half a sample
    late acts like a damping of the other sign.

    Parameters
    ----------
    column : int
        The input.
    design : Design
        The model, without what may have taken the place of both.
    part, held : Segments
        Pieces of the training records as they are, and with the input held.

    Returns
    -------
    bool
    """
    (alone,) = _gains([column], design, part)
    beside = [score(design, one, _missing(design, one), pairs=False) for one in (held, part)]
    then, now = (scores[0].value if scores else 0.0 for scores in beside)
    return alone + then - now > LEAD


def free_to_be_held(records: Sequence[Record]) -> list[int]:
    """Return the inputs that may be held in all records, none of them known as such."""
    return [
        column
        for column in range(records[0].n_inputs)
        if all(may_be_held(record, column) and column not in record.held for record in records)
    ]


def in_pieces(part: Segments) -> Segments:
    """Return pieces to judge holds on: a trajectory is one, and leaves none."""
    return segments(part.records) if part.by_trajectory else part


def _best(ways: Sequence[Memory], design: Design, part: Segments) -> Memory:
    """Return the first of several ways, the plainest first, that does as well as the best."""
    return plainest(ways, [exchange.gain for exchange in exchanged(ways, design, part)])


def _gains(columns: Sequence[int], design: Design, part: Segments) -> list[float]:
    late = (HALF * part.records[0].raw_dt,)
    ways = [_Hold(DELAY, column, late) for column in columns]
    return [exchange.gain for exchange in exchanged(ways, design, part)]


def _missing(design: Design, part: Segments) -> list[Candidate]:
    return propose(design, quick_fit(design, part), part)


def memory_beside_hold(
    memory: Memory, design: Design, part: Segments
) -> tuple[float, Memory | None]:
    """Return by how much an input with a memory is late as it is held, and what it still remembers.

    Parameters
    ----------
    memory : Memory
        Tuned for an input that is not held.
    design : Design
        The model.
    part : Segments
        Pieces of the training records without this memory.

    Returns
    -------
    late : float
        Sampling times; zero if the input is known as held, the records show no jumps (if a user
        made them, they would not), or the hold does worse.
    memory : Memory or None
        None if the hold is all there is.
    """
    column, kind, records = memory.column, memory.kind, part.records
    known = any(column in record.held for record in records)
    if known or not any(may_be_held(record, column) for record in records):
        return (0.0, memory) if known or not _may_be_hold(memory, records) else (HALF, None)
    steps = [record.raw_dt for record in records]
    jumping = all(jumps_at_once(record, column) for record in records)
    alike = jumping and np.ptp(steps) <= EVEN * steps[0]
    share = memory.values[0] / steps[0]
    hold = _Hold(kind, column, memory.values)
    if alike and kind == DELAY and share < LATEST:
        return (HALF if _best([hold, memory], design, part) is hold else share), None
    behind = reach_of(_BehindHold(kind, column, memory.values), design, part)
    alone = [] if alike and kind == DELAY else [hold]
    best = _best([*alone, behind, memory], design, part)
    if best is memory:
        return 0.0, memory
    return HALF, Memory(kind, column, behind.values) if best is behind else None
