"""Find memories of the inputs beside all other effects, and settle how long they reach back."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np
from scipy.optimize import minimize_scalar

from ..memory import DELAY, LAG, VESSEL, Memory, remembered
from ..signals import Record
from ..substitution import substituted
from ..terms import Sum, constant, mul, sub, variable
from .candidate import Candidate
from .design import Column, Design
from .encompassing import chance
from .fit import derivative_intervals
from .probes import RATIO, Exchange, MemoryCandidate, Probes, exchanges, grid_of
from .rejected import Rejected
from .rivals import Rival
from .rules import Rules
from .scoring import MARGIN, columns_of, proposer_for
from .segments import Segments
from .spectral import spectral_grams
from .step import Finding, find

__all__ = ["MemoryFinding", "exchanged", "find_or_recall", "memories_of", "memory_interval"]
__all__ += ["resettled", "settled"]


@dataclass(frozen=True, eq=False)
class MemoryFinding(Finding):
    """A memory of an input that passed. It changes the records and adds no column."""

    memory: Memory = field(kw_only=True)


def memories_of(findings: Sequence[Finding]) -> tuple[Memory, ...]:
    """Return the memories among findings, in the order in which they are applied."""
    return tuple(f.memory for f in findings if isinstance(f, MemoryFinding))


def find_or_recall(
    declared: Design,
    design: Design,
    records: Sequence[Record],
    part: Segments,
    rules: Rules,
    rng: np.random.Generator,
    present: Sequence[Memory] = (),
    rejected: list[Rejected] | None = None,
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

    Returns
    -------
    list of Finding
    """
    memories = grid_of(design, records, part, present)
    if not memories:
        return find(declared, design, records, part, rules, rng, rejected=rejected)
    probes = Probes(design, tuple(memories))
    extended = [probes.extended(record) for record in records]
    wide = probes.widened(declared), probes.widened(design)
    pieces = part.of(extended)
    failed: list[Rejected] = []
    proposer = partial(probes.propose, part=part, offer=proposer_for(design, part, records))
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
    terms = tuple(probes.narrow(term) for term in candidate.terms)
    parents = tuple(probes.narrow(term) for term in candidate.parents)
    return replace(candidate, terms=terms, parents=parents)


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
    memory, rivals = settled(candidate.memory, probes.design, records, part, level, rng, present)
    named = replace(_plain(candidate, probes), name=memory.kind)
    return MemoryFinding(
        named,
        (),
        finding.score,
        finding.p_value,
        finding.twin_scores,
        rivals=tuple(Rival(replace(named, name=k), p) for k, p in rivals),
        memory=memory,
    )


def settled(
    memory: Memory,
    design: Design,
    records: Sequence[Record],
    part: Segments,
    level: float,
    rng: np.random.Generator,
    present: Sequence[Memory] = (),
) -> tuple[Memory, tuple[tuple[str, float], ...]]:
    """Tune how long a memory reaches back, and compare it with the other kinds at their best.

    Parameters
    ----------
    memory : Memory
        From the grid.
    design, records, part
        The model, training records without this memory, pieces of them.
    level : float
        A rival with a smaller p-value is refuted.
    rng : numpy.random.Generator
        Draws the signs.
    present : sequence of Memory
        Memories that the records have already.

    Returns
    -------
    memory : Memory
        Of the plainest kind that does as well as the best.
    rivals : tuple of (str, float)
        Kinds that could stand in its place, with their p-values.
    """
    tried = {m.kind for m in grid_of(design, records, part, present) if m.column == memory.column}
    kinds = [kind for kind in (DELAY, LAG, VESSEL) if kind in tried]
    best = [_tuned(replace(memory, kind=kind), design, records, part) for kind in kinds]
    compared = exchanged(best, design, records, part)
    top = max(exchange.gain for exchange in compared)
    chosen = next(k for k, e in enumerate(compared) if e.gain >= top - max(MARGIN, 0.01 * top))
    others = [m for m in best if m is not best[chosen]]
    rivals = [(m.kind, _chance_of(m, best[chosen], design, records, part, rng)) for m in others]
    return best[chosen], tuple((kind, p_value) for kind, p_value in rivals if p_value > level)


def exchanged(
    memories: Sequence[Memory], design: Design, records: Sequence[Record], part: Segments
) -> list[Exchange]:
    """Return what each of several memories does to the held-out errors of a design."""
    probes = Probes(design, tuple(memories))
    extended = [probes.extended(record) for record in records]
    swaps = [probes.swap(k) for k in range(len(memories))]
    return exchanges(probes.widened(design), part.of(extended), swaps)


def _tuned(memory: Memory, design: Design, records: Sequence[Record], part: Segments) -> Memory:
    start = float(np.log(memory.values[0]))

    def at(log_value: float) -> Memory:
        return replace(memory, values=(float(np.exp(log_value)),))

    reach = 1.5 * float(np.log(RATIO))
    found = minimize_scalar(
        lambda place: -exchanged([at(place)], design, records, part)[0].gain,
        bounds=(start - reach, start + reach),
        method="bounded",
        options={"maxiter": 20, "xatol": 0.01},
    )
    return at(float(found.x))


def _chance_of(
    rival: Memory,
    chosen: Memory,
    design: Design,
    records: Sequence[Record],
    part: Segments,
    rng: np.random.Generator,
) -> float:
    """Return the chance that one memory gains as much beside another, if that were the cause."""
    probes = Probes(design, (rival, chosen))
    pieces = part.of([probes.extended(record) for record in records])
    wide = probes.widened(design)
    there = _swapped(wide, probes.swap(0))
    columns = [*there.columns, *_swapped(wide, probes.swap(1)).columns]
    n_own = len(wide.columns)
    grams = spectral_grams(pieces, there, columns)
    return chance(grams, range(n_own), range(n_own, 2 * n_own), rng)


def _swapped(design: Design, swap: dict[int, Sum]) -> Design:
    """Return a design with variables replaced."""
    columns = tuple(
        replace(c, parts=tuple(substituted(p, swap) for p in c.parts)) for c in design.columns
    )
    return replace(design, columns=columns, fixed=tuple(substituted(p, swap) for p in design.fixed))


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
        others = memories_of([f for f in kept if f is not finding])
        there = [remembered(record, others) for record in records]
        tuned = _tuned(finding.memory, design, there, part.of(there))
        (exchange,) = exchanged([tuned], design, there, part.of(there))
        place = kept.index(finding)
        kept[place : place + 1] = (
            [replace(finding, memory=tuned)] if exchange.gain >= MARGIN else []
        )
    return kept


STEP = 0.02  # of a delay or time constant, to see what it changes


def memory_interval(
    memory: Memory,
    design: Design,
    coef: np.ndarray,
    records: Sequence[Record],
    rng: np.random.Generator,
) -> tuple[float, float]:
    """Return the 95 % interval of a delay or time constant, from blocks of the training data.

    What a small change of it does to the rates is one more column of the model; the interval of
    that column's coefficient is how far the value could be off.

    Parameters
    ----------
    memory : Memory
        The memory, tuned.
    design : Design
        The model.
    coef : ndarray of shape (n_columns,)
        Its coefficients.
    records : sequence of Record
        Training records without this memory.
    rng : numpy.random.Generator
        Draws the blocks.

    Returns
    -------
    low, high : float
    """
    (value,) = memory.values
    longer = replace(memory, values=(value * (1.0 + STEP),))
    probes = Probes(design, (memory, longer))
    extended = [probes.extended(record) for record in records]
    swap, swap_longer = probes.swap(0), probes.swap(1)
    own = len(design.states) + memory.column
    sides = [probes.widen(side) for side in design.equations(coef).sums]
    slopes = tuple(
        mul(
            constant(1.0 / (STEP * value)),
            sub(substituted(side, swap_longer), substituted(side, swap)),
        )
        if own in side.variables
        else Sum(())
        for side in sides
    )
    wide = _swapped(probes.widened(design), swap).adding([Column("change", slopes)])
    low, high = derivative_intervals(wide, extended, rng)[-1]
    half = 0.5 * float(high - low)
    return max(value - half, 0.0), value + half
