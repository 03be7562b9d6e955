"""Terms that no name fits: grown by genetic programming on what the model leaves.

The search sees every other segment only. What it finds is then tested on the segments in between,
as one fixed candidate among few, so the size of the search does not enter the chance of an error.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from joblib import Parallel, delayed

from ...breeding.dictionary import Problem
from ...breeding.generation import Settings
from ...breeding.poles import has_pole
from ...evolution import evolve
from ...operators import Operator
from ...terms import Product, variable
from ...threads import one_thread
from ..effects.candidate import OFFSET, Candidate
from ..effects.missing import candidates, fitted, standing, zeros_of
from ..effects.stops import is_stop
from ..evidence.findings import Finding, with_columns
from ..evidence.scoring import columns_of, net, score
from ..evidence.shares import view_gain
from ..evidence.spectral import spectral_rows, spectral_weights
from ..evidence.step import find
from ..evidence.trace import EVOLVED, Score
from ..fitting.fit import derivative_intervals
from ..fitting.residual import forces
from ..given.design import Design
from ..given.rows import have_values
from ..given.rules import Rules
from ..given.segments import Segments
from .climbing import climbed
from .levels import begun_at_levels
from .naming import named, shifted, without_signs
from .seeds import screened, small_terms, varied

__all__ = ["OPERATORS", "TermGrower", "grow"]

# Without sums inside a term, which would add newtons to meters; sums of terms grow anyway. What
# saturates as x/(c + |x|), like a reaction, has an operator of its own for that.
OPERATORS = ("mul", "div", "abs", "sgn", "sqrt", "sin", "cos", "tanh", "exp", "log", "softsign")
N_SEEDS = 40  # small terms that the search begins with
N_FINALISTS = 6  # that are tested as well: what does best by itself need not be in the equation
SETTINGS = Settings(population_size=80, n_generations=20, max_depth=4, max_terms=6, patience=6)
# Times the log error that names gain, or two of them that of a grown term: the same effect filtered
# does a little better.
BETTER = 1.25
USEFUL = 0.1  # log error that it must gain in the derivative or in the simulation besides


def grow(
    declared: Design,
    design: Design,
    part: Segments,
    operators: Sequence[Operator],
    rng: np.random.Generator,
    n_jobs: int | None = None,
) -> list[Candidate]:
    """Grow terms on top of a design, for each equation that may lack something.

    Parameters
    ----------
    declared : Design
        The model at the start, with whose terms the search begins as well.
    design : Design
        The model so far; its columns are refitted beside every term.
    part : Segments
        Pieces to search in.
    operators : sequence of Operator
        Basis functions.
    rng : numpy.random.Generator
        Source of all randomness.
    n_jobs : int, optional
        Processes that work on the equations; the result does not depend on it.

    Returns
    -------
    list of Candidate
        One for each term, under the name of the vocabulary if one fits.
    """
    known = candidates(design, part.ranges)
    extra = [column for candidate in known for column in columns_of(candidate, design)]
    weights = spectral_weights(part, design, [*design.columns, *extra])
    force = forces(part, design, design.columns, weighed=False)
    flat = force.reshape(-1, *force.shape[2:])
    variables = part.z[..., :-1].reshape(len(flat), -1)
    searches = (
        delayed(_grow_in)(
            state,
            Problem(
                variables,
                flat[:, state, -1],
                flat[:, state, :-1],
                partial(_project, part=part, state=state, weight=weight),
            ),
            known,
            declared.terms_of(state),
            design,
            part,
            operators,
            stream,
        )
        for state, weight, stream in zip(
            design.open_states, weights, rng.spawn(len(design.open_states)), strict=True
        )
    )
    found: list[list[Candidate]] = Parallel(n_jobs=n_jobs)(searches)
    return [candidate for one in found for candidate in one]


@one_thread()
def _grow_in(
    state: int,
    problem: Problem,
    known: Sequence[Candidate],
    declared: Sequence[Product],
    design: Design,
    part: Segments,
    operators: Sequence[Operator],
    rng: np.random.Generator,
) -> list[Candidate]:
    """Grow terms in one equation, whose declared ones the search begins with as well."""
    variables = problem.x
    small = [*small_terms(operators, variables), *varied(declared, operators, variables)]
    seeds = screened(problem, list(dict.fromkeys(small)), N_SEEDS)
    evolution = evolve(
        variables,
        problem.target,
        operators=_without_quotients(operators),
        rng=rng,
        fixed=problem.fixed,
        project=problem.project,
        begin=seeds,
        settings=SETTINGS,
        keep_if_interrupted=False,  # the loop says itself that it was interrupted
    )
    # The best seed too: the search may drop what it holds for long, though it explains most.
    finalists = (*evolution.terms, *evolution.finalists[:N_FINALISTS], *seeds[:1])
    name = partial(
        named,
        state=state,
        known=known,
        variables=variables,
        signed=shifted(design, state, part.ranges.signed),
        declared=declared,
    )
    plain = (one for term in finalists for one in without_signs(term, variables))
    grown = [name(term) for term in dict.fromkeys(plain)]
    grown += [name(term) for term in _above(grown, design, part, operators, declared)]
    return list(dict.fromkeys([*grown, *begun_at_levels(design, state, part)]))


def _without_quotients(operators: Sequence[Operator]) -> list[Operator]:
    """Return operators without division, unless there are sums to divide by.

    The small terms that a search begins with hold the reciprocals of what keeps away from zero.
    """
    sums = any(operator.name in ("add", "sub") for operator in operators)
    return [operator for operator in operators if sums or operator.name != "div"]


def _above(
    grown: Sequence[Candidate],
    design: Design,
    part: Segments,
    operators: Sequence[Operator],
    declared: Sequence[Product],
) -> list[Product]:
    """Return the term to which the best one without a name climbs, if that is worth its nodes."""
    free = [replace(c, parents=()) for c in grown if c.name == EVOLVED]
    best = max(score(design, part, free, pairs=False), key=net, default=None)
    if best is None or net(best) <= 0.0:
        return []
    top = climbed(best.group[0], design, part, operators, declared)
    return [term for _, term in top.terms[0].parts]


def _project(columns: np.ndarray, part: Segments, state: int, weight: np.ndarray) -> np.ndarray:
    """Map rows to weighed spectra, real and imaginary parts below each other."""
    n_segments, length, _ = part.z.shape
    moving = columns.reshape(n_segments, length, -1) * part.weight[:, :, state, None]
    rows = spectral_rows(part, moving) * weight[None, :, None]
    stacked = np.concatenate([rows.real, rows.imag], axis=1)
    return stacked.reshape(-1, rows.shape[-1])


class TermGrower:
    """Grown terms beside the vocabulary: where they do clearly better, and where nothing else does.

    Parameters
    ----------
    declared : Design
        The model at the start.
    part : Segments
        Pieces of the training records: every other one is searched in, those between are tested on.
    rules : Rules
        When a term counts.
    operators : sequence of Operator
        Basis functions; without any, nothing grows.
    rng : numpy.random.Generator
        Source of all randomness.
    """

    def __init__(
        self,
        declared: Design,
        part: Segments,
        rules: Rules,
        operators: Sequence[Operator],
        rng: np.random.Generator,
    ) -> None:
        self.declared, self.rules = declared, rules
        self.operators, self.rng = operators, rng
        self.look(part)
        self.pool: list[Candidate] | None = None
        self.grown: list[Candidate] = []

    def look(self, part: Segments) -> None:
        """Search in every other of these pieces, and test on those between."""
        self.seen, self.fresh = part.every_other(0), part.every_other(1)

    def better(self, design: Design, found: Sequence[Finding]) -> list[Finding]:
        """Return what does clearly better on fresh segments than named effects.

        That is a grown term, or a leak k (x - x0) unless a grown one does clearly better than it.
        """
        if self.pool is None:
            self.pool = self._grow(self.declared)
        names = [finding.candidate for finding in found]
        ours = score(design, self.fresh, [*names, *_zeros_beside(names, design)], pairs=True)
        named_scores = [len(s.group) * net(s) for s in ours if set(names) <= set(s.group)]
        bar = BETTER * max(named_scores, default=0.0)
        fresh = [c for c in self.pool if c.name == EVOLVED or is_stop(c)]
        best = max(score(design, self.fresh, fresh, pairs=False), key=net, default=None)
        leak = self._leak(design, names[0].state)
        if leak is not None and 2.0 * net(leak) > max(bar, net(best) / BETTER if best else 0.0):
            return self._test(design, list(leak.group))
        if best is None or net(best) <= bar:
            return []
        if BETTER * net(best) <= self._of_two_names(design, best.group[0].state):
            return []
        return self._test(design, list(best.group))

    def _leak(self, design: Design, state: int) -> Score | None:
        """Return what a state and an offset gain together in its equation of the first order."""
        known = candidates(design, self.fresh.ranges)
        straight = ((variable(state),), (OFFSET,))
        both = [c for c in known if c.state == state and c.terms in straight]
        if design.position_of(state) is not None or len(both) < 2:
            return None
        pairs = (s for s in score(design, self.fresh, both, pairs=True) if len(s.group) == 2)
        return next(pairs, None)

    def _of_two_names(self, design: Design, state: int) -> float:
        """Return what two names gain together in an equation: a leak k (p - p0) takes two looks."""
        known = candidates(design, self.fresh.ranges)
        offered = [candidate for candidate in known if candidate.state == state]
        pairs = (s for s in score(design, self.fresh, offered, pairs=True) if len(s.group) == 2)
        return max((2.0 * net(pair) for pair in pairs), default=0.0)

    def find(self, design: Design, n_searches: int = 1) -> list[Finding]:
        """Grow terms on what a design leaves, and return the best one that passes."""
        grown = [c for _ in range(n_searches) for c in self._grow(design)]
        return self._test(design, list(dict.fromkeys(grown)))

    def _grow(self, design: Design) -> list[Candidate]:
        if not self.operators or self.seen.by_trajectory or len(self.fresh.z) < MIN_FRESH:
            return []
        known = fitted(design)  # what is known may be wrong
        grown = grow(self.declared, design, self.seen, self.operators, self.rng, self.rules.n_jobs)
        fresh = (c for c in grown if (c.state, c.terms[0]) not in known)
        rows, records = self.seen.rows, self.seen.records
        new = [
            c
            for c in fresh
            if have_values(c.terms, records) and not any(has_pole(t, rows) for t in c.terms)
        ]
        self.grown += new
        return new

    def _test(self, design: Design, grown: list[Candidate]) -> list[Finding]:
        # Pairs too: 3 sin(v) - 4 sin(v)^3 is sin(3 v), and neither term gains anything alone.
        scores = [s for s in score(design, self.fresh, grown, pairs=True) if net(s) > 0.0]
        useful = [s for s in scores if view_gain(design, s.group, self.fresh) > USEFUL]
        given = partial(_given, list(dict.fromkeys(c for s in useful for c in s.group)))
        look = find(self.declared, design, self.fresh, self.rules, self.rng, given)
        found = list(look.found)
        return found if found and self._are_certain(design, found) else []

    def _are_certain(self, design: Design, found: Sequence[Finding]) -> bool:
        """Tell whether all records together know the sign of each coefficient."""
        richer = with_columns(design, found)
        low, high = derivative_intervals(richer, self.fresh.records, self.rng).T
        own = slice(len(design.columns), None)
        return bool(np.all(low[own] * high[own] > 0.0))


def _zeros_beside(names: Sequence[Candidate], design: Design) -> list[Candidate]:
    """Return the offsets that names may still get, to say where a state is measured from."""
    terms = {(c.state, term) for c in names for term in c.terms}
    zeros = zeros_of(terms, len(design.states)) - terms - standing(design)
    return [Candidate("constant offset", state, (term,)) for state, term in zeros]


MIN_FRESH = 4  # segments to test on; a shorter record is left to the vocabulary


def _given(grown: list[Candidate], *_: object) -> list[Candidate]:
    return grown
