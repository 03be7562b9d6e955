"""The order of the looks: names, what remembers, what runs show, grown terms; what falls again."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ..hidden_states.memory import Memory, preceded, remembered
from ..operators import Operator
from ..signals import Record
from ..signals.holds import hold
from .effects.candidate import Candidate
from .evidence.findings import (
    Finding,
    MemoryFinding,
    SensorFinding,
    limits_in,
    memories_in,
    next_step,
    with_columns,
    with_findings,
)
from .evidence.offers import awaited
from .evidence.rejected import Rejected
from .evidence.structure import structure_chance
from .evidence.trace import EVOLVED
from .fitting.unfolding import paths_of
from .free_runs.by_runs import find_by_runs
from .free_runs.comparison import held_against
from .free_runs.contenders import Pool
from .free_runs.one_for_several import one_for_several
from .free_runs.sensor_limits import clipped_sensors
from .free_runs.shared_tuning import numbers_by_runs, shared_by_runs
from .free_runs.two_for_one import two_for_one
from .free_runs.unnamed import find_unnamed
from .free_runs.variants import Model
from .given.design import Design
from .given.held import held_inputs, held_where_it_jumps
from .given.limits import off_limits
from .given.rules import Rules
from .given.segments import Segments
from .growth.grow import TermGrower
from .growth.naming import small_candidates
from .growth.short import find_small, is_better
from .memories.chains import Traded, untraded
from .memories.find import find_with_memories, resettled
from .memories.holds import memory_beside_hold
from .revision.beginnings import settled_beginning
from .revision.errors_in_inputs import without_errors_in_inputs
from .revision.hidden_numbers import needed_by_runs, smooth_in, with_numbers, with_numbers_of_runs
from .revision.revise import exchange, merged, prune
from .revision.sharing import with_shared_numbers
from .revision.superseded import without_outlived
from .revision.thinning import thinned

__all__ = ["Search"]

N_SEARCHES = 5  # for grown terms, where they are the only hope: one search may miss them
LIKELY = 0.2  # chance that the residual has no structure, up to which there is such a hope


@dataclass
class Search:
    """What a search has found so far, also if it is interrupted.

    Runs are compared with the `plain` records, derivatives with the `wide` ones, whose cutoff is
    higher and of which `whole` are the pieces. `part` and `grower` are what these become with the
    memories and limits that were found.
    """

    declared: Design
    plain: Sequence[Record]
    whole: Segments
    rules: Rules
    operators: Sequence[Operator]
    rng: np.random.Generator
    findings: list[Finding] = field(default_factory=list)
    rejected: Rejected | None = None  # the last one
    chance_left: float = 1.0  # that what is left only seems to depend on what was measured
    relaxing: bool = True  # whether to look for relaxations, and springs that remember
    part: Segments = field(init=False)
    grower: TermGrower = field(init=False)

    @property
    def wide(self) -> tuple[Record, ...]:
        """The records without memories whose derivatives are looked at."""
        return self.whole.records

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
        return held_inputs(self.plain)

    @property
    def design(self) -> Design:
        """The model with what was found until now."""
        return with_findings(self.declared, self.findings)

    @property
    def runs_tell_more(self) -> bool:
        """Whether there are free runs that nothing was compared with yet, as trajectories are."""
        return not self.declared.algebraic and not self.whole.by_trajectory

    def run(self) -> None:
        """Find effects until none passes: names, what only runs show, then terms without a name."""
        self._look_through(self.findings)
        self._find_named()
        self._tune_memories()
        if self.runs_tell_more:
            self._find_by_runs()
        if self.part.by_trajectory:
            self._grow_by_trajectory()
        else:
            self._grow_terms()
        if self.runs_tell_more:
            self._find_unnamed()
            self._hold_against_rivals()
            self._doubt_inputs()
            self._find_clipped_sensors()
        self._judge_rest()

    def withdraw(self, place: int) -> None:
        """Take a finding back, and look at what is left without it."""
        self.findings = [f for k, f in enumerate(self.findings) if k != place]
        self._look_through(self.findings)
        self._judge_rest()

    def hold_instead(self) -> None:
        """Take inputs as held between samples instead of late, which was all that was found."""
        memories, self.findings = memories_in(self.findings), []
        step = self.plain[0].raw_dt
        self._take_as_held({one.column: one.values[0] / step for one in memories}, hold)
        self._judge_rest()

    def _take_as_held(
        self, late: Mapping[int, float], holding: Callable[[Record, Mapping[int, float]], Record]
    ) -> None:
        self.plain = [holding(record, late) for record in self.plain]
        self.whole = self.whole.of([holding(record, late) for record in self.wide])
        self._look_through(self.findings)

    def _look_through(self, findings: Sequence[Finding]) -> None:
        """Look at the records as they are with the memories and limits among the findings."""
        memories, limits = memories_in(findings), limits_in(findings)
        acted = [remembered(record, memories) for record in self.wide]
        self.part = off_limits(self.whole.of(acted), limits) if findings else self.whole
        self.grower = TermGrower(self.declared, self.part, self.rules, self.operators, self.rng)
        self._wait(findings)

    def _wait(self, findings: Sequence[Finding]) -> None:
        """Look at records only where each relaxation knows where it is."""
        self.part = awaited(with_findings(self.declared, findings), self.part)
        self.grower.look(self.part)

    def _find_named(self) -> None:
        """Add what has a name, or remembers, one after the other until none passes."""
        while len(self.findings) < self.rules.max_effects:
            before, memories = self.findings, memories_in(self.findings)
            new = _numbered(self._look_for_names(memories), before)
            if not new:
                break
            if memories_in(new):
                kept = self._without_holds(new)
                if not kept:  # it was how the input was recorded, and no memory of the machine
                    continue
                found = self._begun(untraded([*before, *kept]))
            else:
                found = self._or_grown(before, new)
            if len(found) <= len(before):  # a memory goes where records begin otherwise
                self.findings = found
                break
            self._take(found, before)
            if len(new) > 1 or len(memories_in(self.findings)) == len(memories):
                self._tune_memories()  # or what is wrong with one would be named as another one
        kept = prune(self.declared, self.findings, self.part)
        self.findings = merged(self.declared, kept, self.part)

    def _look_for_names(self, memories: Sequence[Memory]) -> Sequence[Finding]:
        """Look once for what has a name, or remembers."""
        relaxing, springs = self.relaxing and not memories, self.relaxing
        given = self.declared, self.design, self.part, self.rules, self.rng, memories
        look = find_with_memories(*given, relaxing=relaxing, springs=springs)
        self.rejected = look.rejected or self.rejected
        return look.found

    def _or_grown(self, before: list[Finding], new: list[Finding]) -> list[Finding]:
        """Return all findings with new ones, or with what grows and does clearly better."""
        both, design = [*before, *new], self.design
        # Growing takes long, and may be interrupted.
        self.findings = before if self._relaxes(both, before) else both
        self._wait(both)
        grown = self.grower.better(design, new)
        return [*before, *(_numbered(grown, before) or new)]

    def _take(self, found: list[Finding], before: list[Finding]) -> None:
        """Keep findings, earlier ones under the names and numbers that they have by now."""
        found = exchange(self.declared, found, self.part)
        found = with_numbers(self.declared, found, self.part)
        self.findings = with_shared_numbers(self.declared, found, self.part)
        self._take_back(before)

    def _relaxes(self, findings: list[Finding], before: list[Finding]) -> bool:
        """Tell whether a relaxation or a spring came in, which needs more proof than others."""
        sides = (with_findings(self.declared, those) for those in (findings, before))
        now, known = (len(smooth_in(side)) for side in sides)
        return now > known

    def _take_back(self, before: list[Finding]) -> None:
        """Take back a relaxation or a spring that runs do not need, and what came with it."""
        if self._relaxes(self.findings, before):
            needed = needed_by_runs(self.declared, self.findings, self.part.records)
            if len(needed) < len(self.findings):
                self.findings, self.relaxing = before, False
                self._look_through(before)

    def _without_holds(self, found: list[Finding]) -> list[Finding]:
        """Take inputs as held where that does as well as a memory, and return what is left."""
        left = []
        for finding in found:
            if isinstance(finding, MemoryFinding) and not isinstance(finding.memory, Traded):
                late, memory = memory_beside_hold(finding.memory, self.design, self.part)
                if late > 0.0:
                    self._take_as_held({finding.memory.column: late}, held_where_it_jumps)
                if memory is None:
                    return []
                finding = replace(finding, memory=memory)
            left.append(finding)
        return left

    def _begun(self, findings: list[Finding]) -> list[Finding]:
        """Look through the records as memories make them, begun where their first rows say."""
        part = awaited(with_findings(self.declared, findings), self.whole)
        begun = settled_beginning(self.declared, findings, self.plain, part)
        self.plain, self.whole = begun.plain, self.whole.begun(begun.wide)
        self._look_through(begun.findings)
        return list(begun.findings)

    def _tune_memories(self) -> None:
        if memories_in(self.findings):
            part = awaited(self.design, self.whole)
            self.findings = resettled(self.findings, self.design, part)
            self._look_through(self.findings)

    def _find_by_runs(self) -> None:
        child = self.rng.spawn(1)[0]
        if paths_of(self.design):  # whose state those runs do not have
            return
        model = Model(self.declared, memories_in(self.findings), limits_in(self.findings))
        tuned = numbers_by_runs(model, self.findings, self.plain)
        self.findings = merged(self.declared, tuned, self.part)
        look, pasts = find_by_runs(
            self.declared, self.findings, self.plain, self.wide, self.rules, child
        )
        self.rejected = look.rejected or self.rejected
        known, more = self.findings, list(look.found[len(self.findings) :])
        if more:
            new = self._without_holds(more)
            if not new:  # it was how the input was recorded
                self._find_by_runs()
                return
            self.findings = [*known, *new]
            if pasts:
                self.plain = [*map(preceded, self.plain, pasts)]
                self.whole = self.whole.begun([*map(preceded, self.wide, pasts)])
            self._look_through(self.findings)

    def _grow_by_trajectory(self) -> None:
        """Let a small term come in where no name did, or where it does better than all of them."""
        if not self.operators or self.rules.max_effects == 0:
            return
        found = find_small(self.declared, self.part, self.rules, self.operators, self.rng)
        if found and is_better(self.declared, found, self.findings, self.part):
            self.findings = _numbered(found, [])
            self._find_named()

    def _grow_terms(self) -> None:
        n_searches = 1
        if not self.findings:
            # Not on the pieces that grown terms are tested on: their number would depend on those.
            chance = structure_chance(self.declared, self.grower.seen, self.rules, self.rng)
            n_searches = N_SEARCHES if chance <= LIKELY else 1
        while len(self.findings) < self.rules.max_effects:
            found = self.grower.find(self.design, n_searches)
            if not found:
                break
            self.findings = [*self.findings, *_numbered(found, self.findings)]

    def _find_unnamed(self) -> None:
        child = self.rng.spawn(1)[0]
        if paths_of(self.design):
            return
        small = self._small_terms()
        look = find_unnamed(
            self.declared, self.findings, self.plain, self.wide, small, self.rules, child
        )
        self.rejected, self.findings = look.rejected or self.rejected, list(look.found)

    def _judge_rest(self) -> None:
        self.chance_left = structure_chance(self.design, self.part, self.rules, self.rng)

    def _hold_against_rivals(self) -> None:
        self._drop_superfluous()
        if paths_of(self.design):
            found = with_numbers_of_runs(self.declared, self.findings, self.part.records)
            self.findings = needed_by_runs(self.declared, found, self.part.records)
            return
        model = Model(self.declared, memories_in(self.findings), limits_in(self.findings))
        grown = [c for c in self.grower.grown if c.name == EVOLVED]
        small = self._small_terms()
        found = shared_by_runs(model, self.findings, self.plain)
        pool = Pool(grown, small, self.part, -np.log1p(-self.rules.min_share))
        found = one_for_several(model, found, pool, self.plain)
        found = two_for_one(model, found, self.plain, self.part, self.rules)
        kept = held_against(model, found, pool, self.plain, self.rules)
        kept = shared_by_runs(model, kept, self.plain)  # what won may have partners
        self.findings = prune(self.declared, kept, self.part)

    def _doubt_inputs(self) -> None:
        child = self.rng.spawn(1)[0]
        found = without_errors_in_inputs(self.declared, self.findings, self.wide, self.part, child)
        self.findings = prune(self.declared, found, self.part)

    def _small_terms(self) -> list[Candidate]:
        return small_candidates(self.design, self.part, self.operators)

    def _drop_superfluous(self) -> None:
        """Drop what grown terms made superfluous, once each has the name that is right by now."""
        found = exchange(self.declared, self.findings, self.part)
        kept = prune(self.declared, found, self.part)
        if not paths_of(self.design):
            kept = without_outlived(self.declared, kept, self.plain, self.wide)
        if len(memories_in(kept)) < len(memories_in(self.findings)):
            self._look_through(kept)
        self.findings = thinned(self.declared, kept, self.part)

    def _find_clipped_sensors(self) -> None:
        found = self.findings
        if len(found) < self.rules.max_effects:
            whole = with_columns(self.declared, found)
            model = Model(whole, memories_in(found), limits_in(found))
            self.findings = clipped_sensors(model, found, self.plain, self.rules, self.rng)


def _numbered(found: Sequence[Finding], before: Sequence[Finding]) -> list[Finding]:
    step = next_step(before)
    return [replace(finding, step=step) for finding in found]
