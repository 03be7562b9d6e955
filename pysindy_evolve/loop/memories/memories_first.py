"""Whether a relaxation is more than a memory of an input.

A state that lags behind by itself and one whose input comes late look alike through the few times
on the grid of memories, so memories are tuned before the two are compared.
"""

from __future__ import annotations

from collections.abc import Sequence

from ...hidden_states.memory import Memory
from ...signals import Record
from ..effects.candidate import Candidate, renumbered
from ..evidence.offers import leading
from ..evidence.scoring import score, tuned
from ..given.design import Design
from ..given.segments import Segments
from .probes import Probes
from .reach import best_of_kinds, reach_of

__all__ = ["outdoes_memories"]


def outdoes_memories(
    ways: Sequence[Candidate],
    design: Design,
    records: Sequence[Record],
    part: Segments,
    memories: Sequence[Memory],
) -> bool:
    """Tell whether one of several ways leads all memories of inputs, each tuned.

    Parameters
    ----------
    ways : sequence of Candidate
        Relaxations.
    design : Design
        The model so far.
    records : sequence of Record
        Training records.
    part : Segments
        Pieces of them.
    memories : sequence of Memory
        The grid.

    Returns
    -------
    bool
    """
    first = best_of_kinds(memories, design, records, part)
    rivals = tuple(reach_of(memory, design, records, part) for memory in first.values())
    top = score(design, part, ways, pairs=False)[0].group[0]
    probes = Probes(design, rivals)
    wide = probes.widened(design)
    pieces = part.of([probes.extended(record) for record in records])
    own = [renumbered(way, probes.widen) for way in (*ways, tuned(top, design, part))]
    late = [probes.candidate(wide, k) for k in range(len(rivals))]
    return bool(leading(own, late, wide, pieces))
