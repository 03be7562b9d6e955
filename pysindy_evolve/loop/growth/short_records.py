"""Grown terms on short records, scored by their trajectories.

A genetic search needs unseen pieces to test its terms on, and a short record has none to spare.
So a fixed list of small terms is searched instead, in the record and in each twin, like the
vocabulary.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from itertools import combinations_with_replacement

import numpy as np

from ...equations import Equations
from ...operators import Operator
from ...terms import Product, mul, only_term, variable
from ..effects.candidate import Candidate
from ..effects.missing import candidates, fitted_terms
from ..effects.names import EVOLVED
from ..effects.shaping import shape_of
from ..evidence.findings import Finding, with_columns
from ..evidence.step import find
from ..fitting.linear import log_ratio
from ..fitting.trajectory import Trajectories
from ..given.design import Design
from ..given.ranges import Ranges
from ..given.rows import variables_of
from ..given.rules import Rules
from ..given.segments import Segments
from .naming import has_arbitrary_zero, named
from .seeds import small_terms

MAX_TERMS = 300  # terms to try in all equations together; the smallest are kept
# Gain in log error that a term needs per node that it has more than the names.
MIN_GAIN_PER_NODE_LOG = 0.1


def find_small(
    declared: Design,
    part: Segments,
    rules: Rules,
    operators: Sequence[Operator],
    rng: np.random.Generator,
) -> list[Finding]:
    """Look for a small term that the declared model lacks.

    Parameters
    ----------
    declared : Design
        The model at the start.
    part : Segments
        Pieces of the training records, to be scored by their trajectories.
    rules : Rules
        Significance and twins.
    operators : sequence of Operator
        Basis functions.
    rng : numpy.random.Generator
        Draws the twins.

    Returns
    -------
    list of Finding
        One, or none if none passes.
    """
    proposer = partial(_proposed, operators=operators)
    look = find(declared, declared, part, rules.for_small_terms, rng, proposer)
    return list(map(_plain, look.found))


def is_better(
    declared: Design, found: Sequence[Finding], names: Sequence[Finding], part: Segments
) -> bool:
    """Tell whether a small term does clearly better than all named effects together.

    Parameters
    ----------
    declared : Design
        The model at the start.
    found, names : sequence of Finding
        The term, and the effects with names.
    part : Segments
        Pieces of the training records, to be scored by their trajectories.

    Returns
    -------
    bool
        The gain must pay for each extra node of the term, and for at least one.
    """
    errors = [_error(with_columns(declared, findings), part) for findings in (names, found)]
    sizes = [sum(finding.candidate.size for finding in findings) for findings in (names, found)]
    return not names or log_ratio(*errors) > MIN_GAIN_PER_NODE_LOG * max(sizes[1] - sizes[0], 1)


def _error(design: Design, part: Segments) -> float:
    every = np.arange(len(design.columns))[None, :]
    return float(Trajectories(part.records, design, design.columns).errors(every)[0, 0])


def _proposed(
    design: Design, _: Equations, part: Segments, *, operators: Sequence[Operator]
) -> list[Candidate]:
    """Return the small terms that are not in the vocabulary; each is scored by itself."""
    rows = np.concatenate([variables_of(record) for record in part.records])
    terms = sorted(_terms(operators, rows[:, :-1]), key=lambda term: (term.size, term.constants))
    terms = terms[: MAX_TERMS // len(design.open_states)]
    ranges = Ranges.of(rows)
    known, present = candidates(design, ranges), fitted_terms(design)
    found = []
    for state in design.open_states:
        shiftable = has_arbitrary_zero(design, state, ranges.signed)
        grown = [named(term, state, known, rows[:, :-1], shiftable) for term in terms]
        found += [c for c in grown if c.name == EVOLVED and (state, c.terms[0]) not in present]
    return [replace(c, parents=(), shape=shape_of(c), never_paired=True) for c in found]


def _terms(operators: Sequence[Operator], x: np.ndarray) -> list[Product]:
    """Return products of two functions of one variable, and of three variables."""
    found = small_terms(operators, x)
    if any(operator.name == "mul" for operator in operators):
        triples = combinations_with_replacement(map(variable, range(x.shape[1])), 3)
        found += [only_term(mul(mul(a, b), c)) for a, b, c in triples]
    return list(dict.fromkeys(found))


def _plain(finding: Finding) -> Finding:
    return replace(finding, candidate=replace(finding.candidate, shape=None, never_paired=False))
