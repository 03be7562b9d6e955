"""Terms that no name fits: grown by genetic programming on what the model leaves."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from itertools import product

import numpy as np
from joblib import Parallel, delayed

from ...breeding.dictionary import Problem
from ...breeding.generation import Settings
from ...evolution import evolve
from ...operators import Operator
from ...terms import Product
from ...threads import one_thread
from ..effects.candidate import Candidate, bare
from ..effects.missing import candidates
from ..effects.names import EVOLVED
from ..evidence.scoring import columns_of, net, score
from ..evidence.spectral import spectral_rows, spectral_weights
from ..fitting.residual import forces
from ..given.design import Design
from ..given.segments import Segments
from .climbing import climbed, with_best_numbers
from .levels import begun_at_levels
from .naming import named, shifted, without_signs
from .seeds import screened, small_terms, varied

__all__ = ["OPERATORS", "grow"]

# Without sums inside a term, which would add newtons to meters; sums of terms grow anyway. What
# saturates as x/(c + |x|), like a reaction, has an operator of its own for that.
OPERATORS = ("mul", "div", "abs", "sgn", "sqrt", "sin", "cos", "tanh", "exp", "log", "softsign")
N_SEEDS = 40  # small terms that the search begins with
N_FINALISTS = 6  # that are tested as well: what does best by itself need not be in the equation
SETTINGS = Settings(population_size=80, n_generations=20, max_depth=4, max_terms=6, patience=6)


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
    own = [candidate for one in found for candidate in one]
    named_ones = {(candidate.state, candidate.terms) for candidate in (*known, *own)}
    elsewhere = dict.fromkeys(_from_elsewhere(design))
    return own + [one for one in elsewhere if (one.state, one.terms) not in named_ones]


def _from_elsewhere(design: Design) -> Iterator[Candidate]:
    """Go through what is declared or was found in one equation, for the others.

    What leaves a store enters another. It was read before, so it costs no more than a node.
    """
    for column in design.columns:
        for part, state in product(column.parts, design.open_states):
            if part.variables and not column.parts[state].parts:
                one = Candidate(EVOLVED, state, (bare(part),))
                yield replace(one, free_nodes=one.size - 1)


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
    # A seed with the right form and a wrong number explains less than a wrong form may.
    begun = _without_names([name(term) for term in seeds])
    grown += [name(term) for term in with_best_numbers(begun, design, part, declared)]
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
    free = _without_names(grown)
    best = max(score(design, part, free, pairs=False), key=net, default=None)
    if best is None or net(best) <= 0.0:
        return []
    top = climbed(best.group[0], design, part, operators, declared)
    return [term for _, term in top.terms[0].parts]


def _without_names(grown: Sequence[Candidate]) -> list[Candidate]:
    return [replace(candidate, parents=()) for candidate in grown if candidate.name == EVOLVED]


def _project(columns: np.ndarray, part: Segments, state: int, weight: np.ndarray) -> np.ndarray:
    """Map rows to weighed spectra, real and imaginary parts below each other."""
    n_segments, length, _ = part.z.shape
    moving = columns.reshape(n_segments, length, -1) * part.weight[:, :, state, None]
    rows = spectral_rows(part, moving) * weight[None, :, None]
    stacked = np.concatenate([rows.real, rows.imag], axis=1)
    return stacked.reshape(-1, rows.shape[-1])
