"""Whether an effect is more than a memory of an input.

A state that lags behind by itself and one whose input comes late look alike through the few times
on the grid of memories, and so do a damping and a delay in a closed loop. So memories are tuned
before the two are compared.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...hidden_states.memory import VESSEL, Memory
from ..effects.candidate import Candidate, rewritten
from ..evidence.findings import Finding
from ..evidence.offers import leading
from ..evidence.scoring import MARGIN, score, tuned
from ..given.design import Design
from ..given.segments import Segments
from .probes import MemoryCandidate, Probes
from .reach import best_of_kinds, exchanged, reach_of

__all__ = ["memory_instead", "outdoes_memories"]

WORTH_IT = 0.5  # share of the gain that input and memory together must reach, to be tuned


def outdoes_memories(
    ways: Sequence[Candidate], design: Design, part: Segments, memories: Sequence[Memory]
) -> bool:
    """Tell whether one of several ways leads all memories of inputs, each tuned.

    Parameters
    ----------
    ways : sequence of Candidate
        Relaxations.
    design : Design
        The model so far.
    part : Segments
        Pieces of the training records.
    memories : sequence of Memory
        The grid.

    Returns
    -------
    bool
    """
    top = score(design, part, ways, pairs=False)[0].group[0]
    beside = _Beside.of([*ways, tuned(top, design, part)], design, part, memories)
    return bool(leading(beside.own, beside.late, beside.design, beside.part))


def memory_instead(
    found: Sequence[Finding], design: Design, part: Segments, memories: Sequence[Memory]
) -> Memory | None:
    """Return the delay or lag of an input that does better than what was found instead of it.

    Parameters
    ----------
    found : sequence of Finding
        An effect, or a pair of them; no memory.
    design, part, memories
        As in `outdoes_memories`.

    Returns
    -------
    Memory or None
        Tuned; None if none does better.
    """
    value = sum(finding.score for finding in found)
    linear = [memory for memory in memories if memory.kind != VESSEL]
    both = exchanged(linear, design, part)
    able = [m for m, e in zip(linear, both, strict=True) if e.gain_beside > WORTH_IT * value]
    if not able:
        return None
    beside = _Beside.of([f.candidate for f in found], design, part, able)
    offered = [*beside.own, *beside.late]
    scores = score(beside.design, beside.part, offered, pairs=len(found) > 1)
    totals = {frozenset(s.group): s.value * len(s.group) for s in scores}
    ours = totals.get(frozenset(beside.own), np.inf)
    gains = [totals.get(frozenset([one]), -np.inf) for one in beside.late]
    return beside.late[int(np.argmax(gains))].memory if max(gains) > ours + MARGIN else None


@dataclass(frozen=True, eq=False)
class _Beside:
    """Effects, and the best memories of each input, tuned, in one widened model."""

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
        first = best_of_kinds(memories, design, part)
        rivals = tuple(reach_of(memory, design, part) for memory in first.values())
        probes = Probes(design, rivals)
        wide = probes.widened(design)
        own = [rewritten(one, probes.widen) for one in effects]
        late = [probes.candidate(wide, k) for k in range(len(rivals))]
        return cls(own, late, wide, probes.extended_pieces(part))
