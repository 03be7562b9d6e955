"""Find memories of the inputs beside all other effects, and look at them again in the end."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from ...hidden_states.memory import Memory, remembered
from ...signals import Record
from ...terms import variable
from ..effects.candidate import Candidate, renumbered
from ..evidence.findings import Finding, MemoryFinding, memories_in
from ..evidence.offers import offer_for
from ..evidence.rejected import Rejected
from ..evidence.rivals import Rival
from ..evidence.scoring import MARGIN, columns_of
from ..evidence.step import find
from ..given.design import Design
from ..given.rules import Rules
from ..given.segments import Segments
from .memories_first import outdoes_memories
from .probes import MemoryCandidate, Probes, grid_of
from .reach import exchanged, reach_of, settled_memory

__all__ = ["find_or_recall", "resettled"]


def find_or_recall(
    declared: Design,
    design: Design,
    records: Sequence[Record],
    part: Segments,
    rules: Rules,
    rng: np.random.Generator,
    present: Sequence[Memory] = (),
    rejected: list[Rejected] | None = None,
    *,
    relaxing: bool = True,
) -> list[Finding]:
    """Return what a design lacks, as `find` does, with memories of the inputs among it.

    Parameters
    ----------
    declared, design, records, part, rules, rng
        As in `find`.
    present : sequence of Memory
        Memories that the inputs of the records have already.
    rejected : list of Rejected, optional
        As in `find`.
    relaxing : bool
        Whether relaxations may be among it.

    Returns
    -------
    list of Finding
    """
    memories = grid_of(design, records, part, present)
    offer = offer_for(design, part, records, relaxing=relaxing)
    if not memories:
        return find(declared, design, records, offer.part, rules, rng, offer.propose, rejected)
    if offer.relaxes and not outdoes_memories(offer.ways, design, records, offer.part, memories):
        offer = offer_for(design, part, records, relaxing=False)
    part = offer.part
    probes = Probes(design, tuple(memories))
    extended = [probes.extended(record) for record in records]
    wide = probes.widened(declared), probes.widened(design)
    pieces = part.of(extended)
    failed: list[Rejected] = []
    proposer = partial(probes.propose, part=part, offer=offer.propose)
    found = find(*wide, extended, pieces, rules, rng, proposer, failed)
    if rejected is not None:
        rejected += [_narrowed_failure(one, probes) for one in failed]
    return [
        _narrowed(finding, probes, records, part, rules.significance, rng, present)
        for finding in found
    ]


def _narrowed_failure(failure: Rejected, probes: Probes) -> Rejected:
    group = tuple(_plain(candidate, probes) for candidate in failure.tried.group)
    return replace(failure, tried=replace(failure.tried, group=group))


def _plain(candidate: Candidate, probes: Probes) -> Candidate:
    """Return a candidate with variables numbered as without probes."""
    if isinstance(candidate, MemoryCandidate):
        term = variable(len(probes.design.states) + candidate.memory.column)
        return replace(candidate, terms=(term,), parents=())
    return renumbered(candidate, probes.narrow)


def _narrowed(
    finding: Finding,
    probes: Probes,
    records: Sequence[Record],
    part: Segments,
    level: float,
    rng: np.random.Generator,
    present: Sequence[Memory],
) -> Finding:
    """Return a finding as it stands without probes."""
    candidate = finding.candidate
    if not isinstance(candidate, MemoryCandidate):
        plain = _plain(candidate, probes)
        return replace(finding, candidate=plain, columns=columns_of(plain, probes.design))
    memory, rivals = settled_memory(
        candidate.memory, probes.design, records, part, level, rng, present
    )
    named = replace(_plain(candidate, probes), name=memory.kind)
    return MemoryFinding(
        named,
        (),
        finding.score,
        finding.p_value,
        finding.twin_scores,
        rivals=tuple(Rival(replace(named, name=k), p) for k, p in rivals),
        contested=True,
        memory=memory,
    )


def resettled(
    findings: Sequence[Finding], design: Design, records: Sequence[Record], part: Segments
) -> list[Finding]:
    """Tune memories again beside all that was found, and drop those that became superfluous.

    Parameters
    ----------
    findings : sequence of Finding
        Everything found.
    design : Design
        The model with all their columns.
    records : sequence of Record
        Training records without memories.
    part : Segments
        Pieces of them.

    Returns
    -------
    list of Finding
    """
    kept = list(findings)
    for finding in (f for f in findings if isinstance(f, MemoryFinding)):
        others = memories_in([f for f in kept if f is not finding])
        there = [remembered(record, others) for record in records]
        tuned = reach_of(finding.memory, design, there, part.of(there))
        (exchange,) = exchanged([tuned], design, there, part.of(there))
        place = kept.index(finding)
        kept[place : place + 1] = (
            [replace(finding, memory=tuned)] if exchange.gain >= MARGIN else []
        )
    return kept
