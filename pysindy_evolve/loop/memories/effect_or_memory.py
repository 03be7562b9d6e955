"""Whether an effect explains more than a memory of an input does.

A state with a lag of its own and one with a late input look alike to the few lengths on the grid of
memories. So do a damping and a delay in a closed loop. So memories are tuned before they are
compared with an effect.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...hidden_states.memory import VESSEL, Memory
from ..effects.candidate import Candidate, rewritten
from ..evidence.findings import Finding
from ..evidence.offers import leading
from ..evidence.scoring import MIN_GAIN_LOG, score, tuned
from ..given.design import Design
from ..given.segments import Segments
from .length_and_kind import best_of_kinds, exchanged, reach_of
from .probes import MemoryCandidate, Probes

WORTH_IT = 0.5  # share of the effect's gain that input and memory together must reach to be tuned


def beats_tuned_memories(
    ways: Sequence[Candidate], design: Design, part: Segments, memories: Sequence[Memory]
) -> bool:
    """Tell whether one of several effects gains clearly more than all tuned memories of inputs.

    Parameters
    ----------
    ways : sequence of Candidate
        What may follow a state: relaxations, and masses that swing.
    design : Design
        The model so far.
    part : Segments
        Pieces of the training records.
    memories : sequence of Memory
        The grid of memories.

    Returns
    -------
    bool
    """
    best = score(design, part, ways, pairs=False)[0].group[0]
    comparison = _Beside.of([*ways, tuned(best, design, part)], design, part, memories)
    return bool(leading(comparison.own, comparison.late, comparison.design, comparison.part))


def memory_instead(
    found: Sequence[Finding], design: Design, part: Segments, memories: Sequence[Memory]
) -> Memory | None:
    """Return a delay or lag of an input that does clearly better than the effects found.

    Parameters
    ----------
    found : sequence of Finding
        An effect, or a pair of them; no memory.
    design, part, memories
        As in `beats_tuned_memories`.

    Returns
    -------
    Memory or None
        Tuned; None if none does better.
    """
    effect_gain = sum(finding.score for finding in found)
    linear = [memory for memory in memories if memory.kind != VESSEL]
    exchanges = exchanged(linear, design, part)
    promising = [
        m for m, e in zip(linear, exchanges, strict=True) if e.gain_beside > WORTH_IT * effect_gain
    ]
    if not promising:
        return None
    comparison = _Beside.of([f.candidate for f in found], design, part, promising)
    offered = [*comparison.own, *comparison.late]
    scores = score(comparison.design, comparison.part, offered, pairs=len(found) > 1)
    totals = {frozenset(s.group): s.value * len(s.group) for s in scores}
    own_total = totals.get(frozenset(comparison.own), np.inf)
    gains = [totals.get(frozenset([late]), -np.inf) for late in comparison.late]
    return (
        comparison.late[int(np.argmax(gains))].memory
        if max(gains) > own_total + MIN_GAIN_LOG
        else None
    )


@dataclass(frozen=True, eq=False)
class _Beside:
    """Effects, and the best memory of each kind and input, tuned, in one widened model."""

    own: list[Candidate]
    late: list[MemoryCandidate]
    design: Design
    part: Segments

    @classmethod
    def of(
        cls,
        effects: Sequence[Candidate],
        design: Design,
        part: Segments,
        memories: Sequence[Memory],
    ) -> _Beside:
        best = best_of_kinds(memories, design, part)
        rivals = tuple(reach_of(memory, design, part) for memory in best.values())
        probes = Probes(design, rivals)
        wide = probes.widened(design)
        own = [rewritten(effect, probes.widen) for effect in effects]
        late = [probes.candidate(wide, k) for k in range(len(rivals))]
        return cls(own, late, wide, probes.extended_pieces(part))
