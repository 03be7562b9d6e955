"""One step of the loop: the best candidate, tested on twins."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from ...terms import Sum
from ..effects.candidate import Candidate
from ..effects.missing import offsets_setting_zeros, terms_in
from ..effects.partners import apart
from ..effects.pumped_terms import is_partner_pump
from ..given.design import Column, Design
from ..given.rules import Rules
from ..given.segments import Segments
from .findings import Finding
from .p_values import chance_of
from .plainest import plainest, without_number
from .ranking import Score
from .refinement import justified
from .rejected import Rejected
from .scoring import Proposer, columns_of, quick_fit, score, sharpened, tuned
from .shares import Shares, is_exact

# Score of an effect that halves the RMS error: it matters, whatever its share.
ERROR_HALVED = float(np.log(4.0))


@dataclass(frozen=True, eq=False)
class Look:
    """The findings of a look, or else the best candidate, which did not pass."""

    found: tuple[Finding, ...] = ()
    rejected: Rejected | None = None


def find(
    declared: Design,
    design: Design,
    part: Segments,
    rules: Rules,
    rng: np.random.Generator,
    proposer: Proposer,
) -> Look:
    """Look for the effect, or the pair of effects, that a design lacks.

    Parameters
    ----------
    declared : Design
        The model at the start; shares are of its error.
    design : Design
        The model so far.
    part : Segments
        Pieces of the training records.
    rules : Rules
        When an effect counts.
    rng : numpy.random.Generator
        Draws the twins.
    proposer : callable
        Maps design, equations and pieces of records to candidates.

    Returns
    -------
    Look
    """
    if is_exact(design, part):
        return Look()
    rules = rules.at(len(design.columns) - len(declared.columns))
    equations = quick_fit(design, part)
    scored = _scored(declared, design, part, proposer(design, equations, part))
    worthy, top = scored.worthy(rules), scored.improving[:1]
    names = (*design.states, *design.inputs, "t")
    # The first look is tested even if its best effect is too small: "complete" needs evidence.
    if not worthy and (design.columns != declared.columns or not top):
        weak = [Rejected(_by_equation(s), scored.shares.of(s), variables=names) for s in top]
        return Look(rejected=weak[0] if weak else None)
    best = without_number(plainest(worthy or top), worthy, scored.shares)
    tunes, observed = scored.statistic_of(best)
    statistic = partial(_best_score, design=design, proposer=proposer, tunes=tunes)
    p_value, twins = chance_of(observed, statistic, design, equations, part, rules, rng)
    if p_value > rules.level or not worthy:
        share, tried = scored.shares.of(best), _by_equation(best)
        tested = Rejected(tried, share, p_value, twins, names, rules.level)
        return Look(rejected=tested)
    group = _tuned_group(best, design, scored.proposed, part, rules, rng)
    evidence = best.value, p_value, twins
    alone = _by_equation(replace(best, group=tuple(group))).group
    return Look(tuple(Finding(one, columns_of(one, design), *evidence) for one in alone))


def _by_equation(score: Score) -> Score:
    """Return a score with effects of several equations as one of each."""
    return replace(score, group=tuple(each for one in score.group for each in apart(one)))


@dataclass(frozen=True, eq=False)
class _Scored:
    """The candidates of a look with their scores, best first: on the grid, and tuned as well."""

    proposed: Sequence[Candidate]
    on_grid: Sequence[Score]
    tuned: Sequence[Score]
    shares: Shares
    zeros: set[tuple[int, Sum]]  # offsets that need no minimum share
    added: Sequence[Column]  # what was found before
    time: int  # the variable that is the time

    @property
    def improving(self) -> list[Score]:
        """The groups that reduce the error at all."""
        return [s for s in self.tuned if s.value > 0.0]

    def worthy(self, rules: Rules) -> list[Score]:
        """Return the groups that remove enough of the error to matter."""
        return [s for s in self.improving if self._continues(s) or self._matters(s, rules)]

    def statistic_of(self, best: Score) -> tuple[bool, float]:
        """Return whether candidates are tuned in the twins too, and the score to compare.

        To tune in each twin takes long, so it is done only where the best effect gains far more off
        the grid. Otherwise its score counts no more than the best on the grid, as twins have no
        more.
        """
        on_grid = self.on_grid[0].value
        tunes = best.value >= on_grid + ERROR_HALVED
        return tunes, best.value if tunes else min(best.value, on_grid)

    def _matters(self, score: Score, rules: Rules) -> bool:
        return score.value >= ERROR_HALVED or self.shares.of(score) >= rules.min_share

    def _continues(self, score: Score) -> bool:
        """Tell whether a group belongs to an effect that stands already: it may be small.

        That is the zero of a state, or a term pumped as one in another equation is.
        """
        terms = {(c.state, term) for c in score.group for term in c.terms}
        if len(score.group) > 1:
            return False
        return terms <= self.zeros or is_partner_pump(score.group[0], self.added, self.time)


def _scored(declared: Design, design: Design, part: Segments, proposed: list[Candidate]) -> _Scored:
    on_grid = score(design, part, proposed)
    proposed = sharpened(design, part, proposed)
    tuned_scores = score(design, part, proposed)
    shares = Shares(declared, design, part, proposed)
    zeros = offsets_setting_zeros(terms_in(design) - terms_in(declared), len(design.states))
    added = [column for column in design.columns if column not in declared.columns]
    return _Scored(proposed, on_grid, tuned_scores, shares, zeros, added, design.time)


def _tuned_group(
    best: Score,
    design: Design,
    proposed: Sequence[Candidate],
    part: Segments,
    rules: Rules,
    rng: np.random.Generator,
) -> list[Candidate]:
    """Return the effects of a group, each tuned beside the others; a refinement must be needed."""
    group = []
    for candidate in best.group:
        beside = _beside(design, best.group, candidate)
        if candidate.must_beat:
            candidate = justified(candidate, beside, proposed, part, rules, rng)
        group.append(tuned(candidate, beside, part))
    return group


def _beside(design: Design, group: Sequence[Candidate], candidate: Candidate) -> Design:
    """Return the design with the other candidates of a group in it."""
    others = (c for c in group if c is not candidate)
    return design.adding(column for c in others for column in columns_of(c, design))


def _best_score(
    part: Segments, *, design: Design, proposer: Proposer, tunes: bool = False
) -> float:
    proposed = proposer(design, quick_fit(design, part), part)
    proposed = sharpened(design, part, proposed) if tunes else proposed
    scores = score(design, part, proposed)  # best first
    return scores[0].value if scores else 0.0
