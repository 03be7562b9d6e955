"""What a search has found so far, and how the records look with it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from ...hidden_states.memory import all_with_memories, with_past_inputs
from ...operators import Operator
from ...signals import Record
from ...signals.zero_order_hold import hold
from ..effects.candidate import Candidate
from ..evidence.findings import (
    Finding,
    SensorFinding,
    excluding,
    limits_in,
    memories_in,
    next_step,
    with_findings,
)
from ..evidence.offers import after_settling
from ..evidence.rejected import Rejected
from ..evidence.structure import structure_chance
from ..fitting.unfolding import paths_of
from ..free_runs.variants import Model
from ..given.design import Design
from ..given.held import held_inputs, held_where_it_may_be
from ..given.limits import off_limits
from ..given.rules import Rules
from ..given.segments import Segments
from ..growth.naming import small_candidates
from ..growth.term_grower import Grown, TermGrower
from ..revision.revise import prune

Holding = Callable[[Record, Mapping[int, float]], Record]
NOT_HELD: Mapping[int, float] = {}


@dataclass(frozen=True, eq=False)
class Found:
    """What a search has found so far: the effects, and how the records are read with them.

    It does not change: each look returns another one, and what depends on the effects follows.

    Attributes
    ----------
    declared : Design
        The model at the start.
    records : sequence of Record
        Training records, which free runs are compared with.
    pieces : Segments
        Pieces of the same records at a higher cutoff, whose derivatives are searched.
    rules : Rules
        When an effect counts.
    operators : sequence of Operator
        Basis functions of the terms that are grown.
    findings : tuple of Finding
        The effects.
    outdone : tuple of Finding
        Effects that later ones made superfluous.
    rejected : Rejected or None
        The last effect that did not pass.
    chance_left : float
        p-value of the test for structure in the final residual.
    relaxing : bool
        Whether relaxations, and springs that remember, are still looked for.
    holds_are_told : bool
        Whether the user said which inputs are held.
    grown : Grown
        Terms that grew on the records as they are read now.
    """

    declared: Design
    records: Sequence[Record]
    pieces: Segments
    rules: Rules
    operators: Sequence[Operator]
    findings: tuple[Finding, ...] = ()
    outdone: tuple[Finding, ...] = ()
    rejected: Rejected | None = None
    chance_left: float = 1.0
    relaxing: bool = True
    holds_are_told: bool = False
    grown: Grown = field(default_factory=Grown)

    @property
    def wide_records(self) -> tuple[Record, ...]:
        """The records whose derivatives are searched."""
        return self.pieces.records

    @cached_property
    def corrected_pieces(self) -> Segments:
        """The pieces with the memories and limits that were found.

        Rows in which a hidden state has not settled yet carry no weight.
        """
        return after_settling(self.design, self.pieces_with(self.findings))

    @cached_property
    def design(self) -> Design:
        """The model with what was found so far."""
        return with_findings(self.declared, self.findings)

    @property
    def bare_model(self) -> Model:
        """The declared model, with the memories and limits among the findings, and no terms."""
        return Model(self.declared, memories_in(self.findings), limits_in(self.findings))

    @property
    def grower(self) -> TermGrower:
        """What grows terms on the pieces as they are now."""
        return TermGrower(
            self.declared, self.corrected_pieces, self.rules, self.operators, self.grown
        )

    @property
    def verdict(self) -> str:
        """What may be said of the declared model by now."""
        if any(not isinstance(finding, SensorFinding) for finding in self.findings):
            return "traced"
        if self.chance_left <= self.rules.level:  # beside what sensors do not show
            return "untraced"
        return "traced" if self.findings else "complete"

    @property
    def held(self) -> Mapping[int, float]:
        """Inputs that are held between their samples, and by how many of them each is late."""
        return held_inputs(self.records)

    @property
    def kinds(self) -> tuple[object, ...]:
        """What was found in which equation or input, without numbers, and how records are read.

        A search that meets the same twice would go in circles.
        """
        effects = Counter((one.candidate.state, one.candidate.form) for one in self.findings)
        memories = Counter((one.kind, one.column) for one in memories_in(self.findings))
        found = frozenset(effects.items()), frozenset(memories.items())
        return found, tuple(sorted(self.held.items())), self.relaxing

    @property
    def has_room(self) -> bool:
        """Whether more effects may be found."""
        return len(self.findings) < self.rules.max_effects

    @property
    def remembers_states(self) -> bool:
        """Whether an effect has a hidden state that follows others, which no free run has."""
        return bool(paths_of(self.design))

    @property
    def runs_tell_more(self) -> bool:
        """Whether free runs tell more than the pieces, as those of short records are runs."""
        return not self.declared.algebraic and not self.pieces.by_trajectory

    def numbered(self, new: Iterable[Finding]) -> list[Finding]:
        """Return what was found in one step, after all that was found before."""
        step = next_step(self.findings)
        return [replace(finding, step=step) for finding in new]

    def small_terms(self) -> list[Candidate]:
        """Return small terms without a name that could still enter."""
        return small_candidates(self.design, self.corrected_pieces, self.operators)

    def pieces_with(
        self, findings: Sequence[Finding], late: Mapping[int, float] = NOT_HELD
    ) -> Segments:
        """Return the pieces as they are with memories and limits, and inputs that may be held."""
        memories, limits = memories_in(findings), limits_in(findings)
        held = [held_where_it_may_be(record, late) for record in self.wide_records]
        part = self.pieces.of(all_with_memories(held, memories))
        return off_limits(part, limits) if findings else part

    def with_findings(self, findings: Sequence[Finding]) -> Found:
        """Return the same with other findings; what grew is forgotten if records look otherwise."""
        alike = all(seen(findings) == seen(self.findings) for seen in (memories_in, limits_in))
        grown = self.grown if alike else Grown()
        return replace(self, findings=tuple(findings), grown=grown)

    def with_rejected(self, rejected: Rejected | None) -> Found:
        """Return the same after a look that rejected something, if it did."""
        return replace(self, rejected=rejected or self.rejected)

    def with_records(self, records: Sequence[Record], wide: Sequence[Record]) -> Found:
        """Return the same with records that are read otherwise, both at their two cutoffs."""
        return replace(self, records=records, pieces=self.pieces.of(wide), grown=Grown())

    def with_held(self, late: Mapping[int, float], holding: Holding) -> Found:
        """Return the same with inputs held between samples, each late by so many of them."""
        return self.with_records(
            [holding(record, late) for record in self.records],
            [holding(record, late) for record in self.wide_records],
        )

    def with_holds_for_delays(self) -> Found:
        """Return the same with inputs held instead of late, where that was all that was found."""
        step = self.records[0].raw_dt
        late = {one.column: one.values[0] / step for one in memories_in(self.findings)}
        return self.with_findings([]).with_held(late, hold)

    def with_pasts_of(self, records: Sequence[Record], wide: Sequence[Record]) -> Found:
        """Return the same with records that differ in what came before them."""
        return replace(self, records=records, pieces=self.pieces.with_pasts_of(wide), grown=Grown())

    def with_past_inputs(self, pasts: Sequence[Sequence[float]]) -> Found:
        """Return the same with inputs before the first sample of each record."""
        sides = (self.records, self.wide_records)
        records, wide = (list(map(with_past_inputs, side, pasts)) for side in sides)
        return self.with_pasts_of(records, wide)

    def without_findings(self) -> Found:
        """Return the records as they are read by now, without findings."""
        return replace(self, findings=(), outdone=(), rejected=None, grown=Grown())

    def without(self, gone: Finding) -> Found:
        """Return what is left without a finding, and with those that it outdid."""
        equation = gone.candidate.state
        back = [finding for finding in self.outdone if finding.candidate.state == equation]
        left = self.with_findings([*excluding(self.findings, gone), *back])
        left = replace(left, outdone=tuple(excluding(self.outdone, *back)))
        if not back:
            return left
        # What comes back may be as superfluous as before, if another one than this outdid it.
        return left.with_findings(prune(self.declared, left.findings, left.corrected_pieces))

    def judged(self, rng: np.random.Generator) -> Found:
        """Return the same, told whether what is left depends on what was measured."""
        chance = structure_chance(self.design, self.corrected_pieces, self.rules, rng)
        return replace(self, chance_left=chance)
