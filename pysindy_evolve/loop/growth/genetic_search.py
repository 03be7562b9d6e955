"""Terms that no name fits, grown by genetic programming on the residual of the model."""

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
from .declared_sums import terms_with_sums
from .levels import terms_from_levels
from .naming import has_arbitrary_zero, named, without_signs
from .seeds import screened, small_terms, varied

# No sums inside a term: they would add newtons to meters, and a model is a sum of terms anyway.
# Softsign stands for what saturates as x/(c + |x|), such as a reaction.
OPERATORS = ("mul", "div", "abs", "sgn", "sqrt", "sin", "cos", "tanh", "exp", "log", "softsign")
N_SEEDS = 40  # small terms that a search starts from
N_FINALISTS = 6  # terms tested as well: the best equation may lack the best single term
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
        The model at the start; its terms, varied, are seeds of the search.
    design : Design
        The model so far; its columns are refitted beside every term.
    part : Segments
        Pieces to search in.
    operators : sequence of Operator
        Basis functions.
    rng : numpy.random.Generator
        Source of all randomness.
    n_jobs : int, optional
        Number of processes; the result does not depend on it.

    Returns
    -------
    list of Candidate
        One for each term, with its name if the vocabulary has it.
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
    grown = [candidate for one in found for candidate in one]
    taken = {(candidate.state, candidate.terms) for candidate in (*known, *grown)}
    transferred = dict.fromkeys(_transferred(design))
    return grown + [one for one in transferred if (one.state, one.terms) not in taken]


def _transferred(design: Design) -> Iterator[Candidate]:
    """Yield the terms of each equation as candidates for the other equations.

    What leaves one store enters another. Such a term is known, so it costs one node only.
    """
    for column in design.columns:
        for part, state in product(column.parts, design.open_states):
            if part.variables and not column.parts[state].parts:
                candidate = Candidate(EVOLVED, state, (bare(part),))
                yield replace(candidate, free_nodes=candidate.size - 1)


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
    """Grow terms in one equation, from small terms and from its declared terms, varied."""
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
    # The best seed too: the search may drop it although it explains most.
    finalists = (*evolution.terms, *evolution.finalists[:N_FINALISTS], *seeds[:1])
    name = partial(
        named,
        state=state,
        known=known,
        variables=variables,
        signed=has_arbitrary_zero(design, state, part.ranges.signed),
        declared=declared,
    )
    plain = (simplified for term in finalists for simplified in without_signs(term, variables))
    grown = [name(term) for term in dict.fromkeys(plain)]
    # A seed of the right form with a wrong number may explain less than a wrong form.
    seed_candidates = _unnamed([name(term) for term in seeds])
    grown += [name(term) for term in with_best_numbers(seed_candidates, design, part, declared)]
    grown += [name(term) for term in _best_improved(grown, design, part, operators, declared)]
    grown += terms_with_sums(design, state, part, operators, variables)
    return list(dict.fromkeys([*grown, *terms_from_levels(design, state, part)]))


def _without_quotients(operators: Sequence[Operator]) -> list[Operator]:
    """Return operators without division, unless there are sums to divide by.

    The seeds already contain the reciprocals of variables that stay away from zero.
    """
    sums = any(operator.name in ("add", "sub") for operator in operators)
    return [operator for operator in operators if sums or operator.name != "div"]


def _best_improved(
    grown: Sequence[Candidate],
    design: Design,
    part: Segments,
    operators: Sequence[Operator],
    declared: Sequence[Product],
) -> list[Product]:
    """Return the best term without a name, improved; nothing if it is not worth its nodes."""
    unnamed = _unnamed(grown)
    best = max(score(design, part, unnamed, pairs=False), key=net, default=None)
    if best is None or net(best) <= 0.0:
        return []
    improved = climbed(best.group[0], design, part, operators, declared)
    return [term for _, term in improved.terms[0].parts]


def _unnamed(grown: Sequence[Candidate]) -> list[Candidate]:
    return [replace(candidate, parents=()) for candidate in grown if candidate.name == EVOLVED]


def _project(columns: np.ndarray, part: Segments, state: int, weight: np.ndarray) -> np.ndarray:
    """Map rows to weighted spectra, imaginary parts stacked below real parts."""
    n_segments, length, _ = part.z.shape
    weighted = columns.reshape(n_segments, length, -1) * part.weight[:, :, state, None]
    rows = spectral_rows(part, weighted) * weight[None, :, None]
    stacked = np.concatenate([rows.real, rows.imag], axis=1)
    return stacked.reshape(-1, rows.shape[-1])
