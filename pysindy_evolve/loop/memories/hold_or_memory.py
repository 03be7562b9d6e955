"""Whether an input is held between its samples, or has a memory.

A hold is a matter of how the input was recorded, and no effect. The record of an input that jumps
within one step shows that it is held, but not when in that step it jumps: a controller jumps at the
sample, somebody's hand at any time. So where such an input acts late by less than a step, there is
no delay: it jumps at the sample, if that fits as well. Where it is late by more, or lags, it is
held first and late after that, unless that fits worse. An input that moves with every sample as if
at random may be a controller's answer to noise; it is held if that fits better. A missing effect
may hide that.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...hidden_states.memory import DELAY, Memory
from ...signals import Record
from ...signals.zero_order_hold import HALF_SAMPLE
from ..effects.candidate import Candidate
from ..evidence.scoring import EXTRA_LEAD_LOG, MIN_GAIN_LOG, propose, quick_fit, score
from ..given.design import Design
from ..given.input_errors import jumps_at_once, may_be_held, may_be_steps
from ..given.segments import Segments, segments
from .length_and_kind import exchanged, plainest, reach_of

# Share of a sampling time by which records that are sampled alike may differ.
MAX_TIME_STEP_SPREAD = 0.01
SHORTEST, LONGEST = 0.4, 0.6  # delay of a hold that a user's low-pass has hidden, sampling times
LATEST = 0.6  # largest delay of a hold, sampling times: half of one, and some error


@dataclass(frozen=True)
class _Hold(Memory):
    """A hold of an input from each sample to the next, if it moves in steps, and no memory."""

    def response(self, t: np.ndarray, u: np.ndarray) -> np.ndarray:
        return _held(t, u, self.column)


@dataclass(frozen=True)
class _BehindHold(Memory):
    """A memory of an input that is held from each sample to the next, if it moves in steps."""

    def response(self, t: np.ndarray, u: np.ndarray) -> np.ndarray:
        return super().response(t, _held(t, u, self.column))


def _held(t: np.ndarray, u: np.ndarray, column: int) -> np.ndarray:
    if not may_be_steps(u):
        return u
    return Memory(DELAY, column, (HALF_SAMPLE * float(t[1] - t[0]),)).response(t, u)


def _may_be_hold(memory: Memory, records: Sequence[Record]) -> bool:
    """Tell whether a memory is as short as a hold, in records without raw inputs."""
    shares = [memory.values[0] / record.dt for record in records]
    unknown = all(record.preparation is None for record in records)
    return unknown and all(SHORTEST < share < LONGEST for share in shares)


def holds_alone(design: Design, part: Segments) -> dict[int, float]:
    """Return which inputs explain more if they are held, without another effect beside it.

    Parameters
    ----------
    design : Design
        The model.
    part : Segments
        Pieces of the training records.

    Returns
    -------
    dict of int to float
        Delay of each such input, sampling times. Inputs that a record declares as held are left
        out.
    """
    free = free_to_be_held(part.records)
    gains = _gains(free, design, in_pieces(part)) if free else []
    return {
        column: HALF_SAMPLE for column, gain in zip(free, gains, strict=True) if gain > MIN_GAIN_LOG
    }


def hold_beside_another(column: int, design: Design, part: Segments, held: Segments) -> bool:
    """Tell whether a hold of an input gains, together with the best candidate beside it.

    A hold and an effect may hide each other: the answer of a controller that comes half a sample
    late acts like a damping of the other sign.

    Parameters
    ----------
    column : int
        The input.
    design : Design
        The model, without effects that may have taken the place of both.
    part, held : Segments
        Pieces of the training records as they are, and with the input held.

    Returns
    -------
    bool
    """
    (alone,) = _gains([column], design, part)
    gain_if_held, gain = (_best_gain(design, pieces) for pieces in (held, part))
    return alone + gain_if_held - gain > EXTRA_LEAD_LOG


def _best_gain(design: Design, part: Segments) -> float:
    """Return what the best candidate of the vocabulary gains."""
    proposed = propose(design, quick_fit(design, part), part)
    scores = score(design, part, proposed, pairs=False)
    return scores[0].value if scores else 0.0


def free_to_be_held(records: Sequence[Record]) -> list[int]:
    """Return the inputs that may be held in all records, and are declared as held in none."""
    return [
        column
        for column in range(records[0].n_inputs)
        if all(may_be_held(record, column) and column not in record.held for record in records)
    ]


def smooth_inputs(records: Sequence[Record]) -> set[int]:
    """Return the inputs that do not show whether they are held, and are declared as held in none.

    Their records are raw: what a user has filtered may be late by that.
    """
    return {
        column
        for column in range(records[0].n_inputs)
        if all(
            record.has_raw_inputs and column not in record.held and not may_be_held(record, column)
            for record in records
        )
    }


def is_late_like_hold(memory: Memory, records: Sequence[Record]) -> bool:
    """Tell whether a memory is a delay by about half a sampling time."""
    shares = (memory.values[0] / record.raw_dt for record in records)
    return memory.kind == DELAY and all(SHORTEST < share < LONGEST for share in shares)


def hold_replaces(effect: Candidate, column: int, design: Design, part: Segments) -> bool:
    """Tell whether a smooth input explains as much if it is held as an effect does.

    Parameters
    ----------
    effect : Candidate
        In place of which the input may be held.
    column : int
        The input.
    design : Design
        The model without the effect.
    part : Segments
        Pieces of the training records.

    Returns
    -------
    bool
    """
    late = Memory(DELAY, column, (HALF_SAMPLE * part.records[0].raw_dt,))
    (exchange,) = exchanged([late], design, part)
    scores = score(design, part, [replace(effect, parents=())], pairs=False)
    enough = max((s.value - MIN_GAIN_LOG for s in scores), default=np.inf)
    return bool(exchange.gain > max(enough, MIN_GAIN_LOG))


def in_pieces(part: Segments) -> Segments:
    """Return pieces to judge holds on: whole trajectories are cut first."""
    return segments(part.records) if part.by_trajectory else part


def _best(memories: Sequence[Memory], design: Design, part: Segments) -> Memory:
    """Return the first of several memories, ordered by plainness, that does as well as the best."""
    return plainest(memories, [exchange.gain for exchange in exchanged(memories, design, part)])


def _gains(columns: Sequence[int], design: Design, part: Segments) -> list[float]:
    late = (HALF_SAMPLE * part.records[0].raw_dt,)
    holds = [_Hold(DELAY, column, late) for column in columns]
    return [exchange.gain for exchange in exchanged(holds, design, part)]


def memory_beside_hold(
    memory: Memory, design: Design, part: Segments
) -> tuple[float, Memory | None]:
    """Return how late an input with a memory is between its samples, and what memory remains.

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
        Sampling times: half of one for a hold, or the delay of jumps within a step. Zero if the
        input is declared as held, if no record shows jumps and the memory is not as short as a hold
        that a user's low-pass has hidden, or if the hold fits worse.
    memory : Memory or None
        None if nothing remains.
    """
    column, kind, records = memory.column, memory.kind, part.records
    known = any(column in record.held for record in records)
    if known or not any(may_be_held(record, column) for record in records):
        return (0.0, memory) if known or not _may_be_hold(memory, records) else (HALF_SAMPLE, None)
    steps = [record.raw_dt for record in records]
    jumping = all(jumps_at_once(record, column) for record in records)
    alike = jumping and np.ptp(steps) <= MAX_TIME_STEP_SPREAD * steps[0]
    share = memory.values[0] / steps[0]
    hold = _Hold(kind, column, memory.values)
    if alike and kind == DELAY and share < LATEST:
        return (HALF_SAMPLE if _best([hold, memory], design, part) is hold else share), None
    behind = reach_of(_BehindHold(kind, column, memory.values), design, part)
    alone = [] if alike and kind == DELAY else [hold]
    best = _best([*alone, behind, memory], design, part)
    if best is memory:
        return 0.0, memory
    return HALF_SAMPLE, Memory(kind, column, behind.values) if best is behind else None
