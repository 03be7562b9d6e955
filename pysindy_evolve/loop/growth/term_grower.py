"""When a grown term counts beside the vocabulary.

The search sees only every other segment. Its terms are then tested on the segments in between, as
a few fixed candidates, so the size of the search does not raise the chance of a false alarm.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from ...breeding.poles import has_pole
from ...operators import Operator
from ...terms import variable
from ..effects.candidate import OFFSET, Candidate
from ..effects.missing import candidates, fitted_terms, offsets_setting_zeros, terms_in
from ..effects.names import CONSTANT_OFFSET, EVOLVED
from ..effects.stops import is_stop
from ..evidence.findings import Finding, with_columns
from ..evidence.ranking import Score
from ..evidence.scoring import net, score
from ..evidence.shares import view_gain
from ..evidence.step import find
from ..fitting.fit import derivative_intervals
from ..given.design import Design
from ..given.rows import have_values
from ..given.rules import Rules
from ..given.segments import Segments
from .genetic_search import grow

# Factor by which a grown term must gain more than names, or two names more than a grown term: a
# filtered copy of the same effect gains a little more by itself.
MIN_GAIN_RATIO = 1.25
USEFUL = 0.1  # log error that a term must also gain in the derivative or in the simulation
MIN_FRESH = 4  # segments to test on, at least; on a shorter record nothing grows


@dataclass
class Grown:
    """Terms that grew on records, as these were read then.

    Attributes
    ----------
    first : list of Candidate, optional
        What grew on the residual of the declared model, once that was looked at.
    terms : list of Candidate
        All that grew.
    """

    first: list[Candidate] | None = None
    terms: list[Candidate] = field(default_factory=list)


class TermGrower:
    """Grows terms: where they do clearly better than names, and where no name passes.

    Parameters
    ----------
    declared : Design
        The model at the start.
    part : Segments
        Pieces of the training records: the search sees every other one, the test those between.
    rules : Rules
        When a term counts.
    operators : sequence of Operator
        Basis functions; without any, nothing grows.
    grown : Grown
        What grew on these records before; what grows now is added.
    """

    def __init__(
        self,
        declared: Design,
        part: Segments,
        rules: Rules,
        operators: Sequence[Operator],
        grown: Grown,
    ) -> None:
        self.declared, self.rules = declared, rules
        self.operators, self.grown = operators, grown
        self.seen, self.fresh = part.every_other(0), part.every_other(1)

    def better(
        self, design: Design, found: Sequence[Finding], rng: np.random.Generator
    ) -> list[Finding]:
        """Return what does clearly better on fresh segments than the named effects.

        That is a grown term, or a leak k (x - x0) unless a grown term does clearly better than it.
        """
        if self.grown.first is None:
            self.grown.first = self._grow(self.declared, rng)
        names = [finding.candidate for finding in found]
        named_scores = score(
            design, self.fresh, [*names, *_zeros_beside(names, design)], pairs=True
        )
        named_gains = [len(s.group) * net(s) for s in named_scores if set(names) <= set(s.group)]
        bar = MIN_GAIN_RATIO * max(named_gains, default=0.0)
        fresh = [c for c in self.grown.first if c.name == EVOLVED or is_stop(c)]
        best = max(score(design, self.fresh, fresh, pairs=False), key=net, default=None)
        leak = self._leak(design, names[0].state)
        leak_bar = max(bar, net(best) / MIN_GAIN_RATIO if best else 0.0)
        if leak is not None and 2.0 * net(leak) > leak_bar:
            return self._test(design, list(leak.group), rng)
        if best is None or net(best) <= bar:
            return []
        if MIN_GAIN_RATIO * net(best) <= self._gain_of_two_names(design, best.group[0].state):
            return []
        return self._test(design, list(best.group), rng)

    def _leak(self, design: Design, state: int) -> Score | None:
        """Return the score of a leak, a state and an offset, in a first-order equation."""
        straight = ((variable(state),), (OFFSET,))
        pair = [c for c in self._offered(design, state) if c.terms in straight]
        if design.position_of(state) is not None or len(pair) < 2:
            return None
        return next(self._pairs(design, pair), None)

    def _gain_of_two_names(self, design: Design, state: int) -> float:
        """Return the best gain of two names in an equation together, as of a leak k (p - p0)."""
        pairs = self._pairs(design, self._offered(design, state))
        return max((2.0 * net(pair) for pair in pairs), default=0.0)

    def _offered(self, design: Design, state: int) -> list[Candidate]:
        """Return the candidates of the vocabulary for an equation."""
        return [c for c in candidates(design, self.fresh.ranges) if c.state == state]

    def _pairs(self, design: Design, offered: Sequence[Candidate]) -> Iterator[Score]:
        """Yield the scores of pairs of effects, best first."""
        scores = score(design, self.fresh, offered, pairs=True)
        return (s for s in scores if len(s.group) == 2)

    def find(self, design: Design, rng: np.random.Generator, n_searches: int = 1) -> list[Finding]:
        """Grow terms on the residual of a design, and return the best one that passes."""
        grown = [c for _ in range(n_searches) for c in self._grow(design, rng)]
        return self._test(design, list(dict.fromkeys(grown)), rng)

    def _grow(self, design: Design, rng: np.random.Generator) -> list[Candidate]:
        if not self.operators or self.seen.by_trajectory or len(self.fresh.z) < MIN_FRESH:
            return []
        known = fitted_terms(design)  # a known coefficient may be wrong, so its term is tried again
        grown = grow(self.declared, design, self.seen, self.operators, rng, self.rules.n_jobs)
        fresh = (c for c in grown if (c.state, c.terms[0]) not in known)
        rows, records = self.seen.rows, self.seen.records
        new = [
            c
            for c in fresh
            if have_values(c.terms, records) and not any(has_pole(t, rows) for t in c.terms)
        ]
        self.grown.terms += new
        return new

    def _test(
        self, design: Design, grown: list[Candidate], rng: np.random.Generator
    ) -> list[Finding]:
        # Pairs too: 3 sin(v) - 4 sin(v)^3 is sin(3 v), and neither term gains anything alone.
        scores = [s for s in score(design, self.fresh, grown, pairs=True) if net(s) > 0.0]
        useful = [s for s in scores if view_gain(design, s.group, self.fresh) > USEFUL]
        given = partial(_always, list(dict.fromkeys(c for s in useful for c in s.group)))
        look = find(self.declared, design, self.fresh, self.rules, rng, given)
        found = list(look.found)
        return found if found and self._are_certain(design, found, rng) else []

    def _are_certain(
        self, design: Design, found: Sequence[Finding], rng: np.random.Generator
    ) -> bool:
        """Tell whether the 95 % interval of each new coefficient excludes zero."""
        richer = with_columns(design, found)
        low, high = derivative_intervals(richer, self.fresh.records, rng).T
        new = slice(len(design.columns), None)
        return bool(np.all(low[new] * high[new] > 0.0))


def _zeros_beside(names: Sequence[Candidate], design: Design) -> list[Candidate]:
    """Return the offsets that named effects still lack, for states with arbitrary zeros."""
    terms = {(c.state, term) for c in names for term in c.terms}
    zeros = offsets_setting_zeros(terms, len(design.states)) - terms - terms_in(design)
    return [Candidate(CONSTANT_OFFSET, state, (term,)) for state, term in zeros]


def _always(grown: list[Candidate], *_: object) -> list[Candidate]:
    return grown
