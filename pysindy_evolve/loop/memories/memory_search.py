"""Find memories of the inputs beside all other effects, and tune them again at the end."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from operator import itemgetter

import numpy as np

from ...hidden_states.memory import LAG, Memory, all_with_memories
from ...terms import variable
from ..effects.candidate import Candidate, rewritten
from ..evidence.findings import Finding, MemoryFinding, excluding, memories_in, with_findings
from ..evidence.offers import offer_for
from ..evidence.rejected import Rejected
from ..evidence.rivals import Rival
from ..evidence.scoring import MIN_GAIN_LOG
from ..evidence.step import Look, find
from ..given.design import Design
from ..given.rules import Rules
from ..given.segments import Segments
from .chains import Chain, Traded, chains_in
from .effect_or_memory import beats_tuned_memories, memory_instead
from .length_and_kind import chain_of, exchanged, reach_of, settled_memory, trade_of
from .probes import MemoryCandidate, Probes, grid_of, users_of


def find_with_memories(
    declared: Design,
    design: Design,
    part: Segments,
    rules: Rules,
    rng: np.random.Generator,
    present: Sequence[Memory] = (),
    *,
    relaxing: bool = True,
    springs: bool = True,
) -> Look:
    """Look for what a design lacks, as `find` does, with memories of the inputs as candidates.

    Parameters
    ----------
    declared, design, part, rules, rng
        As in `find`.
    present : sequence of Memory
        Memories that the inputs of the records have already.
    relaxing, springs : bool
        Whether relaxations, and springs with hysteresis, are candidates.

    Returns
    -------
    Look
    """
    memories = grid_of(design, part, present)
    memories += _tuned_trades(memories, design, part)
    offer = offer_for(design, part, relaxing=relaxing, springs=springs)
    if not memories:
        return find(declared, design, offer.part, rules, rng, offer.propose)
    if offer.relaxes and not beats_tuned_memories(offer.ways, design, offer.part, memories):
        offer = offer_for(design, part, relaxing=False, springs=springs)
    part = offer.part
    probes = Probes(design, tuple(memories))
    wide, pieces = probes.widened(design), probes.extended_pieces(part)
    proposer = partial(probes.propose, offer=offer.propose)
    look = find(probes.widened(declared), wide, pieces, rules, rng, proposer)
    plain = [_narrowed(finding, probes) for finding in look.found]
    if plain and not offer.remembers and not any(isinstance(f, MemoryFinding) for f in plain):
        memory = memory_instead(plain, design, part, memories)
        plain = plain if memory is None else [_as_finding(plain[0], memory, design)]
    level, richer = rules.significance, with_findings(design, plain)
    found = [
        _settled(f, richer, part, level, rng, present) if isinstance(f, MemoryFinding) else f
        for f in plain
    ]
    return Look(_each_once(found), look.rejected and _narrowed_failure(look.rejected, probes))


def _each_once(findings: Sequence[Finding]) -> tuple[Finding, ...]:
    """Leave out a memory of an input that has become one before it: a pair of a lag and a delay."""
    once: dict[object, Finding] = {}
    for f in findings:
        kind = (f.memory.kind, f.memory.column) if isinstance(f, MemoryFinding) else f
        once.setdefault(kind, f)
    return tuple(once.values())


def _tuned_trades(memories: Sequence[Memory], design: Design, part: Segments) -> list[Memory]:
    """Return the best trade of each input, with both of its numbers tuned."""
    trades = [memory for memory in memories if isinstance(memory, Traded)]
    gains = [exchange.gain for exchange in exchanged(trades, design, part)] if trades else []
    best = {m.column: m for _, m in sorted(zip(gains, trades, strict=True), key=itemgetter(0))}
    return [trade_of(memory, design, part) for memory in best.values()]


def _narrowed_failure(failure: Rejected, probes: Probes) -> Rejected:
    group = tuple(_narrowed_candidate(candidate, probes) for candidate in failure.tried.group)
    return replace(failure, tried=replace(failure.tried, group=group))


def _narrowed_candidate(candidate: Candidate, probes: Probes) -> Candidate:
    """Return a candidate with its variables numbered as without probes."""
    if isinstance(candidate, MemoryCandidate):
        term = variable(len(probes.design.states) + candidate.memory.column)
        return replace(candidate, terms=(term,), parents=())
    return rewritten(candidate, probes.narrow)


def _narrowed(finding: Finding, probes: Probes) -> Finding:
    """Return a finding as it is without probes; a memory keeps its length on the grid."""
    plain = _narrowed_candidate(finding.candidate, probes)
    if isinstance(finding.candidate, MemoryCandidate):
        return _as_finding(finding, finding.candidate.memory, probes.design)
    return finding.with_candidate(plain, probes.design)


def _as_finding(finding: Finding, memory: Memory, design: Design) -> MemoryFinding:
    """Return a memory as a finding, with the evidence of another finding."""
    state, term = users_of(design, memory.column)[0], variable(len(design.states) + memory.column)
    named = Candidate(memory.kind, state, (term,))
    evidence = finding.score, finding.p_value, finding.twin_scores
    return MemoryFinding(named, (), *evidence, memory=memory)


def _settled(
    finding: MemoryFinding,
    design: Design,
    part: Segments,
    level: float,
    rng: np.random.Generator,
    present: Sequence[Memory],
) -> MemoryFinding:
    """Return a memory of the best kind, tuned; kinds that do as well become its rivals."""
    if isinstance(finding.memory, Traded):
        return replace(finding, memory=trade_of(finding.memory, design, part))
    memory, rivals = settled_memory(finding.memory, design, part, level, rng, present)
    named = replace(finding.candidate, name=memory.kind)
    others = tuple(Rival(replace(named, name=kind), p_value) for kind, p_value in rivals)
    return replace(finding, candidate=named, memory=memory, rivals=others, contested=True)


def resettled(findings: Sequence[Finding], design: Design, part: Segments) -> list[Finding]:
    """Tune memories again beside all findings, and drop those that gain nothing any more.

    Parameters
    ----------
    findings : sequence of Finding
        Everything found.
    design : Design
        The model with all their columns.
    part : Segments
        Pieces of the training records without memories.

    Returns
    -------
    list of Finding
    """
    findings = _with_tuned_chains(findings, design, part)
    kept = list(findings)
    for finding in (f for f in findings if isinstance(f, MemoryFinding)):
        others = memories_in(excluding(kept, finding))
        pieces = part.of(all_with_memories(part.records, others))
        tuned = reach_of(finding.memory, design, pieces)
        (exchange,) = exchanged([tuned], design, pieces)
        place = kept.index(finding)
        kept[place : place + 1] = (
            [replace(finding, memory=tuned)] if exchange.gain >= MIN_GAIN_LOG else []
        )
    return kept


def with_kinds_rechosen(
    findings: Sequence[Finding],
    design: Design,
    part: Segments,
    level: float,
    rng: np.random.Generator,
) -> list[Finding]:
    """Choose the kind of each memory again, beside what was found after it.

    A drag that is missing in a closed loop can make a lag look like a delay.

    Parameters
    ----------
    findings, design, part
        As in `resettled`.
    level : float
        A kind with a smaller p-value is refuted.
    rng : numpy.random.Generator
        Draws the signs of the bootstrap.

    Returns
    -------
    list of Finding
        Memories that free runs showed, and two of one input, stay as they are. A memory that keeps
        its kind keeps its numbers.
    """
    kept = list(findings)
    for place, finding in enumerate(findings):
        if not isinstance(finding, MemoryFinding) or finding.by_runs or not finding.contested:
            continue
        others = memories_in(excluding(kept, finding))
        if all(other.column != finding.memory.column for other in others):
            pieces = part.of(all_with_memories(part.records, others))
            again = _settled(finding, design, pieces, level, rng, others)
            is_same = again.memory.kind == finding.memory.kind
            kept[place] = replace(finding, rivals=again.rivals) if is_same else again
    return kept


def _with_tuned_chains(
    findings: Sequence[Finding], design: Design, part: Segments
) -> list[Finding]:
    """Return findings with the delay and the lag of one input tuned together."""
    found = list(findings)
    for chain in chains_in(findings):
        others = memories_in([f for f in findings if f not in chain])
        pieces = part.of(all_with_memories(part.records, others))
        values = tuple(finding.memory.values[0] for finding in chain)
        tuned_chain = chain_of(Chain(LAG, chain[0].memory.column, values), design, pieces)
        for finding, value in zip(chain, tuned_chain.values, strict=True):
            tuned = replace(finding.memory, values=(value,))
            found[found.index(finding)] = replace(finding, memory=tuned)
    return found
