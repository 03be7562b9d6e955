"""What a search has found so far, and how the records look with it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ...hidden_states.memory import remembered
from ...operators import Operator
from ...signals import Record
from ...signals.zero_order_hold import acting_through, hold
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
from ..evidence.offers import awaited
from ..evidence.rejected import Rejected
from ..evidence.structure import structure_chance
from ..fitting.unfolding import paths_of
from ..free_runs.variants import Model
from ..given.design import Design
from ..given.held import held_inputs, held_where_it_may_be
from ..given.limits import off_limits
from ..given.rules import Rules
from ..given.segments import Segments
from ..given.through import with_functions
from ..growth.naming import small_candidates
from ..growth.term_grower import TermGrower
from ..revision.revise import prune

__all__ = ["Holding", "Search"]

Holding = Callable[[Record, Mapping[int, float]], Record]
NOTHING: Mapping[int, float] = {}


@dataclass
class Search:
    """What a search has found so far, also if it is interrupted.

    Runs are compared with `records`, derivatives with `wide_records`, whose cutoff is higher and of
    which `pieces` are the pieces. `corrected_pieces` are these with the memories and limits that
    were found; `grower` grows terms on them.
    """

    declared: Design
    records: Sequence[Record]
    pieces: Segments
    rules: Rules
    operators: Sequence[Operator]
    rng: np.random.Generator
    findings: list[Finding] = field(default_factory=list)
    outdone: list[Finding] = field(default_factory=list)  # what later findings made superfluous
    rejected: Rejected | None = None  # the last one
    chance_left: float = 1.0  # p-value of the test for structure in the final residual
    relaxing: bool = True  # whether to look for relaxations, and springs that remember
    corrected_pieces: Segments = field(init=False)
    grower: TermGrower = field(init=False)

    def __post_init__(self) -> None:
        """Look at the records as they are."""
        self.look_through(self.findings)

    @property
    def wide_records(self) -> tuple[Record, ...]:
        """The records without memories whose derivatives are looked at."""
        return self.pieces.records

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
    def design(self) -> Design:
        """The model with what was found so far."""
        return with_findings(self.declared, self.findings)

    @property
    def bare_model(self) -> Model:
        """The declared model, with the memories and limits among the findings, and no terms."""
        return Model(self.declared, memories_in(self.findings), limits_in(self.findings))

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
        """Whether there are free runs that nothing was compared with yet, as trajectories are."""
        return not self.declared.algebraic and not self.pieces.by_trajectory

    def numbered(self, found: Sequence[Finding]) -> list[Finding]:
        """Return what was found in one step, after all that was found before."""
        step = next_step(self.findings)
        return [replace(finding, step=step) for finding in found]

    def small_terms(self) -> list[Candidate]:
        """Return small terms without a name that could still enter."""
        return small_candidates(self.design, self.corrected_pieces, self.operators)

    def look_through(self, findings: Sequence[Finding]) -> None:
        """Look at the records as they are with the memories and limits among the findings."""
        self.corrected_pieces = self.pieces_with(findings)
        self.grower = TermGrower(
            self.declared, self.corrected_pieces, self.rules, self.operators, self.rng
        )
        self.wait(findings)

    def pieces_with(
        self, findings: Sequence[Finding], late: Mapping[int, float] = NOTHING
    ) -> Segments:
        """Return the pieces as they are with memories and limits, and inputs that may be held."""
        memories, limits = memories_in(findings), limits_in(findings)
        held = [held_where_it_may_be(record, late) for record in self.wide_records]
        part = self.pieces.of([remembered(record, memories) for record in held])
        return off_limits(part, limits) if findings else part

    def wait(self, findings: Sequence[Finding]) -> None:
        """Give no weight to the rows in which a hidden state has not settled yet."""
        self.corrected_pieces = awaited(
            with_findings(self.declared, findings), self.corrected_pieces
        )
        self.grower.look(self.corrected_pieces)

    def take_as_held(self, late: Mapping[int, float], holding: Holding) -> None:
        """Take inputs as held between samples, each late by so many of them."""
        self.records = [holding(record, late) for record in self.records]
        self.pieces = self.pieces.of([holding(record, late) for record in self.wide_records])
        self.look_through(self.findings)

    def takes_functions(self) -> bool:
        """Take inputs that jump to act through the functions that were found; forget all findings.

        A low-pass of a function of steps is another signal than the function of the low-pass, and
        in between those effects seem to depend on more. Nothing happens, and False is returned,
        unless a function of an input is found that the declared model does not have; nor where an
        input has a hidden state, such as a lag, as what comes first is not known then.
        """
        acting = self._through_what_was_found()
        if len(acting[0].through) == len(self.records[0].through):
            return False
        self.records, through = acting, acting[0].through
        self.pieces = self.pieces.of(
            [acting_through(record, through) for record in self.wide_records]
        )
        self.forget()
        return True

    def _through_what_was_found(self) -> Sequence[Record]:
        """Return the records with inputs that act through functions among the findings."""
        acting, taken = self.records, list[Finding]()
        if any(memory.has_state for memory in memories_in(self.findings)):
            return acting
        for finding in self.findings:
            design = with_findings(self.declared, [*taken, finding])
            tried = with_functions(design, self.records)
            if len(tried[0].through) > len(acting[0].through):
                acting, taken = tried, [*taken, finding]
        return acting

    def forget(self) -> None:
        """Forget all findings, as the records look otherwise by now."""
        self.findings, self.outdone, self.rejected = [], [], None
        self.look_through([])

    def judge_rest(self) -> None:
        """Ask whether what is left depends on what was measured."""
        self.chance_left = structure_chance(
            self.design, self.corrected_pieces, self.rules, self.rng
        )

    def withdraw(self, place: int) -> None:
        """Take a finding back, and look at what is left without it and with what it outdid."""
        gone, equation = self.findings[place], self.findings[place].candidate.state
        back = [finding for finding in self.outdone if finding.candidate.state == equation]
        self.outdone = excluding(self.outdone, *back)
        left = [*excluding(self.findings, gone), *back]
        self.look_through(left)
        # What comes back may be as superfluous as before, if another one than this outdid it.
        self.findings = prune(self.declared, left, self.corrected_pieces) if back else left
        self.judge_rest()

    def hold_instead(self) -> None:
        """Take inputs as held between samples instead of late, which was all that was found."""
        memories, self.findings = memories_in(self.findings), []
        step = self.records[0].raw_dt
        self.take_as_held({one.column: one.values[0] / step for one in memories}, hold)
        self.judge_rest()
