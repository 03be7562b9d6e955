"""The loop: trace the residual, test the best effect on twins, add it, repeat, prune, report."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import pysindy as ps

from ..memory import preceded, remembered
from ..operators import Operator, resolve
from ..signals import Record
from .algebraic import as_algebraic
from .by_runs import find_by_runs, with_findings
from .clipped import clipped_sensors
from .declared import DeclaredModel, design_of
from .design import Design
from .duels import held_against
from .grow import OPERATORS, Garden
from .halts import limits_in, may_stop_itself
from .limits import off_limits
from .outlived import without_outlived
from .recall import find_or_recall, memories_of, resettled
from .records import alike, check_records, split_records, widened
from .rejected import Rejected
from .report import LoopReport, make_report
from .revise import contested, exchange, merged, prune
from .rules import Rules, generator
from .segments import Segments
from .slopes import told_by_slopes
from .step import Finding
from .structure import structure_chance
from .thinning import thinned
from .trace import EVOLVED
from .unfolding import paths_of
from .variants import Model
from .witness import witnessed
from .yielding import with_numbers, with_numbers_of_runs

__all__ = ["close_loop"]

N_SEARCHES = 5  # for grown terms, where they are the only hope: one search may miss them
LIKELY = 0.2  # chance that the residual has no structure, up to which there is such a hope


def close_loop(
    declared: DeclaredModel | ps.SINDy,
    train: Record | Sequence[Record],
    test: Record | Sequence[Record] | None = None,
    *,
    significance: float = 0.05,
    n_twins: int = 299,
    min_share: float = 0.05,
    max_effects: int = 8,
    refine: str = "auto",
    operators: Sequence[str | Operator] = OPERATORS,
    random_state: int | np.random.Generator | None = None,
    n_jobs: int | None = None,
    progress: bool = False,
) -> LoopReport:
    """Find what a declared model lacks, add it, and report the errors before and after.

    Each step scores every effect of the vocabulary, refitted together with the model, on parts of
    the training data that it was not fitted on, in the derivative and in the simulation. The best
    one is added if twins, in which nothing is missing, hardly ever show an effect so good.

    Parameters
    ----------
    declared : DeclaredModel or pysindy.SINDy
        The model so far; a SINDy model may be fitted or not.
    train : Record or sequence of Record
        Measurements to fit on and to search in.
    test : Record or sequence of Record, optional
        Measurements to judge on, which decide nothing. Without them the last of several records,
        or the last 30 % of a single one, are held out.
    significance : float
        Chance to add an effect where nothing is missing, in (0, 1).
    n_twins : int
        Twins of each step. The smallest possible p-value is 1 / (n_twins + 1).
    min_share : float
        An effect must remove at least this share of the error variance that all candidates
        together could remove, in the derivative or in the simulation, or halve the error that is
        left. Real records always hold traces of something; this says how small a trace matters.
    max_effects : int
        Stop once there are so many effects; two that only show together may make it one more. 0
        only fits the declared model and asks whether it is all.
    refine : {"auto", "derivative", "simulation"}
        Error that the final coefficients minimize. By default it is that of the simulation where
        this predicts parts of the training data better that it was not fitted on, and only there.
    operators : sequence of str or Operator
        Basis functions of the terms that are grown where no name fits; empty to grow none.
    random_state : int, Generator or None
        Seed of the twins and of the search.
    n_jobs : int, optional
        Processes that work on the twins; the result does not depend on it.
    progress : bool
        Show a progress bar.

    Returns
    -------
    LoopReport

    Raises
    ------
    ValueError
        If a setting is out of range, or the records do not fit the model or each other.
    TypeError
        If something is of the wrong type.

    Notes
    -----
    An interrupt (Ctrl-C) ends the search. What was found until then is reported; if that is nothing
    yet, KeyboardInterrupt is raised. Expect 5 to 15 s of one quiet core for 10 000 samples, and
    more with each effect found. The matrices are small: set OMP_NUM_THREADS=1, as threads of the
    linear algebra only get in each other's way.

    Examples
    --------
    >>> import numpy as np
    >>> import pysindy_evolve as pse
    >>> t = np.arange(0.0, 20.0, 0.01)
    >>> q = np.exp(-0.1 * t) * np.cos(2.0 * t) + 0.5
    >>> declared = pse.DeclaredModel({"q": "v", "v": "-k*q - c*v"})
    >>> report = pse.close_loop(declared, pse.prepare(t, q), random_state=0)
    >>> report.verdict, report.effects[0].name
    ('traced', 'constant offset')
    """
    rules = Rules(significance, n_twins, min_share, max_effects, n_jobs, progress, refine)
    fit_on, judge_on = split_records(train, test)
    declared_design = design_of(declared, fit_on)
    is_cut = not test and (isinstance(train, Record) or len(train) == 1)
    whole = sum(record.n_samples for record in (*fit_on, *judge_on)) if is_cut else 0
    check_records(declared_design, [*fit_on, *judge_on], whole)
    fit_on, judge_on = alike(fit_on, judge_on)
    rng = generator(random_state)
    if declared_design.algebraic:
        rules = replace(rules, refine="derivative")  # nothing is simulated
        fit_on, judge_on = ([as_algebraic(r) for r in rs] for rs in (fit_on, judge_on))
    wide = widened(fit_on)
    if declared_design.algebraic:
        wide = [replace(r, x=np.zeros_like(r.x)) for r in wide]  # a target explains nothing
    if may_stop_itself(declared_design, fit_on, rules, rng):
        every = fit_on, judge_on, wide
        fit_on, judge_on, wide = ([replace(r, seen=None) for r in one] for one in every)
    part = witnessed(declared_design, wide)
    rules = replace(rules, by_trajectory=bool(part.tracks))
    basis = resolve(operators, "close_loop") if operators and not part.tracks else ()
    search, finished = _Search(declared_design, fit_on, wide, part, rules, basis, rng), True
    try:
        search.run()
    except KeyboardInterrupt:
        if not search.findings:
            raise
        finished = False
    findings, verdict = search.findings, search.verdict
    finished = finished and len(findings) < rules.max_effects
    acted = part.of([remembered(record, memories_of(findings)) for record in search.wide])
    acted = off_limits(acted, limits_in(findings))
    findings = contested(declared_design, findings, acted, rules.significance, rng.spawn(1)[0])
    findings = told_by_slopes(declared_design, findings, acted)
    seen = search.plain
    report = make_report(declared_design, findings, seen, judge_on, verdict, finished, rules, rng)
    return replace(report, rejected=search.rejected[-1] if search.rejected else None)


@dataclass
class _Search:
    """What a search has found so far, also if it is interrupted.

    Runs are compared with the `plain` records, derivatives with the `wide` ones, of which `whole`
    are the pieces and whose cutoff is higher. `records`, `part` and `garden` are what these become
    with the memories and limits that were found.
    """

    declared: Design
    plain: Sequence[Record]
    wide: Sequence[Record]
    whole: Segments
    rules: Rules
    operators: Sequence[Operator]
    rng: np.random.Generator
    findings: list[Finding] = field(default_factory=list)
    rejected: list[Rejected] = field(default_factory=list)
    has_structure: bool = False

    @property
    def verdict(self) -> str:
        if self.has_structure:  # beside what sensors do not show
            return "untraced"
        return "traced" if self.findings else "complete"

    @property
    def design(self) -> Design:
        return with_findings(self.declared, self.findings)

    def run(self) -> None:
        """Find named effects until none passes, then what only free runs show, then grown terms."""
        self._look_through(self.findings)
        self._name()
        self._settle()
        if not self.declared.algebraic and not self.whole.tracks:  # those were compared with runs
            self._watch_runs()
        self._grow()
        if not self.declared.algebraic and not self.whole.tracks:
            self._hold()
            self._read()

    def _look_through(self, findings: Sequence[Finding]) -> None:
        """Look at the records as they are with the memories and limits among the findings."""
        memories, limits = memories_of(findings), limits_in(findings)
        self.records = [remembered(record, memories) for record in self.wide]
        self.part = off_limits(self.whole.of(self.records), limits) if findings else self.whole
        self.garden = Garden(
            self.declared, self.records, self.part, self.rules, self.operators, self.rng
        )

    def _name(self) -> None:
        while len(self.findings) < self.rules.max_effects:
            before, design = self.findings, self.design
            found = find_or_recall(
                self.declared, design, self.records, self.part, self.rules, self.rng,
                memories_of(before), self.rejected,
            )  # fmt: skip
            if not found:
                break
            if memories_of(found):
                self._look_through([*before, *found])
            else:  # growing takes long, and may be ended
                self.findings = [*before, *_numbered(found, before)]
                found = self.garden.better(design, found) or found
            found = [*before, *_numbered(found, before)]
            found = exchange(self.declared, found, self.part)
            self.findings = with_numbers(self.declared, found, self.part)
        kept = prune(self.declared, self.findings, self.part)
        self.findings = merged(self.declared, kept, self.part)

    def _settle(self) -> None:
        if memories_of(self.findings):
            self.findings = resettled(self.findings, self.design, self.wide, self.whole)
            self._look_through(self.findings)

    def _watch_runs(self) -> None:
        child = self.rng.spawn(1)[0]
        if paths_of(self.design):  # whose state those runs do not have
            return
        found, pasts = find_by_runs(
            self.declared, self.findings, self.plain, self.wide, self.rules, child, self.rejected
        )
        if len(found) > len(self.findings):
            self.findings = found
            if pasts:
                both = (self.plain, self.wide)
                self.plain, self.wide = ([*map(preceded, records, pasts)] for records in both)
            self._look_through(found)

    def _grow(self) -> None:
        n_searches = 1
        if not self.findings:
            # Not on the pieces that grown terms are tested on: their number would depend on those.
            chance = structure_chance(
                self.declared, self.records, self.garden.seen, self.rules, self.rng
            )
            n_searches = N_SEARCHES if chance <= LIKELY else 1
        while len(self.findings) < self.rules.max_effects:
            found = self.garden.find(self.design, n_searches)
            if not found:
                break
            self.findings = [*self.findings, *_numbered(found, self.findings)]
        if not self.findings:
            chance = structure_chance(self.declared, self.records, self.part, self.rules, self.rng)
            self.has_structure = chance <= self.rules.level

    def _hold(self) -> None:
        self._drop()
        if paths_of(self.design):
            self.findings = with_numbers_of_runs(self.declared, self.findings, self.records)
            return
        model = Model(self.declared, memories_of(self.findings), limits_in(self.findings))
        grown = [c for c in self.garden.grown if c.name == EVOLVED]
        kept = held_against(model, self.findings, grown, self.plain, self.part, self.rules)
        self.findings = prune(self.declared, kept, self.part)

    def _drop(self) -> None:
        """Drop what grown terms made superfluous."""
        kept = prune(self.declared, self.findings, self.part)
        if not paths_of(self.design):
            kept = without_outlived(self.declared, kept, self.plain, self.wide)
        if len(memories_of(kept)) < len(memories_of(self.findings)):
            self._look_through(kept)
        self.findings = thinned(self.declared, kept, self.part)

    def _read(self) -> None:
        found = self.findings
        if len(found) < self.rules.max_effects:
            columns = (column for finding in found for column in finding.columns)
            model = Model(self.declared.adding(columns), memories_of(found), limits_in(found))
            self.findings = clipped_sensors(model, found, self.plain, self.rules, self.rng)


def _numbered(found: Sequence[Finding], before: Sequence[Finding]) -> list[Finding]:
    step = 1 + max((finding.step for finding in before), default=0)
    return [replace(finding, step=step) for finding in found]
