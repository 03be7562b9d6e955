"""Algorithm 1 of the paper: the only loop over generations.

======  ====================  ========================================================
symbol  shape                 meaning
======  ====================  ========================================================
x       (n, n_variables)      states and inputs
target  (n,)                  left-hand side of the equation: one column of x_dot
theta   (m, p)                dictionary on the m rows of a sample, columns of unit RMS
======  ====================  ========================================================

Initialise a population of terms; then, each generation: build the dictionary, solve the elastic
net, rate the terms (fitness, lower is better), vary them. Survivors are kept beside the
population, so that a good term can wait for its partners.
"""

from __future__ import annotations

import time
from collections.abc import Hashable, Iterator, Sequence

import numpy as np

from .breeding.constants import tune_beside, tune_constants
from .breeding.dictionary import Dictionary, Problem, Project, build_dictionary
from .breeding.elastic_net import solve_elastic_net
from .breeding.fitness import rate_terms
from .breeding.generation import Evolution, Generation, Settings
from .breeding.genetics import Genetics
from .breeding.plain import plain_terms, sizes
from .breeding.plateau import Plateau
from .breeding.refit import refit
from .breeding.relatives import product_alternatives
from .breeding.watch import watch
from .operators import Operator
from .sparse.parsimony import PERFECT
from .terms import ONE, Product, Variable, lowest
from .threads import one_thread

ROWS_PER_GENERATION = 3000  # rows that a generation is scored on; the final refit sees all of them
FINALISTS = 24  # terms that are weighed against each other on all rows


@one_thread()
def evolve(
    x: np.ndarray,
    target: np.ndarray,
    *,
    operators: Sequence[Operator],
    rng: np.random.Generator,
    fixed: np.ndarray | None = None,
    project: Project | None = None,
    noise: np.ndarray | None = None,
    domain: np.ndarray | None = None,
    begin: Sequence[Product] = (),
    settings: Settings | None = None,
    progress: bool = False,
    keep_if_interrupted: bool = True,
) -> Evolution:
    """Grow the terms of one equation: target = fixed @ a + theta @ coef.

    Parameters
    ----------
    x : ndarray of shape (n, n_variables)
        Variables, in the user's units.
    target : ndarray of shape (n,)
        Left-hand side of the equation.
    operators : sequence of Operator
        Basis functions.
    rng : numpy.random.Generator
        Source of all randomness.
    fixed : ndarray of shape (n, n_fixed), optional
        Columns that are always in the equation; terms are grown on top of them.
    project : callable, optional
        A linear map on the rows of columns, (n, p) to (m, p), applied to theta, fixed columns and
        target alike, such as smooth windows. All rows are then used in each generation.
    noise : ndarray of shape (n_variables,) or (n, n_variables), optional
        Standard deviation of the noise in each variable, or in each of its values. Terms that
        explain less than this noise does are dropped.
    domain : ndarray of shape (k, n_variables), optional
        Further states at which every term must have a value.
    begin : sequence of Product, optional
        Terms of the first generation, besides the simple and random ones.
    settings : Settings, optional
        Parameters of the search.
    progress : bool
        Show a progress bar.
    keep_if_interrupted : bool
        Whether Ctrl-C ends the search with the best equation so far; otherwise it is passed on.

    Returns
    -------
    Evolution

    Notes
    -----
    A generation uses `ROWS_PER_GENERATION` rows, whatever n is, unless `project` is given. The
    search ends after ``n_generations``, or when no new term has entered the equation for
    ``patience`` of them, or sooner where nothing is left to explain, see `plateau`.
    """
    settings = settings or Settings()
    if not target.any():  # a parameter among the states: its equation is empty
        return Evolution((), (), (), ())
    fixed = np.empty((len(x), 0)) if fixed is None else fixed
    problem = Problem(x, target, fixed, project, noise, domain)
    search = generations(problem, operators, settings, rng, begin)
    plateau = Plateau(problem, settings.patience)
    history, finalists, interrupted = watch(
        search, plateau, settings.n_generations, progress, keep_if_interrupted
    )
    n_best = history[-1].n_terms if history else 0
    perfect = bool(history) and history[-1].error <= PERFECT
    finalists = _unique([lowest(term) for term in finalists])
    terms, coef = refit(problem, finalists, n_best, settings.max_terms, perfect)
    return Evolution(terms, coef, history, finalists, interrupted)


def generations(
    problem: Problem,
    operators: Sequence[Operator],
    settings: Settings,
    rng: np.random.Generator,
    begin: Sequence[Product] = (),
) -> Iterator[tuple[Generation, tuple[Product, ...]]]:
    """Algorithm 1. Yield each generation's record, and the terms to weigh on all rows."""
    start = time.perf_counter()
    first = problem.sample(ROWS_PER_GENERATION, np.random.default_rng(0))
    genetics = Genetics(operators, np.array(sizes(first.x)), max_depth=settings.max_depth, rng=rng)
    leaves = (ONE, *(Product(((Variable(i), 1),)) for i in range(problem.x.shape[1])))
    population = first_population(first, genetics, operators, settings, leaves, begin)

    survivors: tuple[Product, ...] = leaves
    best: tuple[Product, ...] = ()
    known: set[Hashable] = set()  # forms that were tuned, and beside which forms
    for number in range(1, settings.n_generations + 1):
        dictionary = build_dictionary(
            problem.sample(ROWS_PER_GENERATION, rng), [*survivors, *population]
        )
        found = solve_elastic_net(
            dictionary, survivors, best, settings.max_terms, smooth=genetics.smooth
        )
        best = tuple(dictionary.terms[j] for j in found.best)
        fitness, partners = rate_terms(dictionary, found.front, found.n_effective)

        ranking = _unique([*best, *_sorted(dictionary, fitness)])[:FINALISTS]
        plain = [leaf for leaf in leaves if leaf in dictionary.terms]  # always weighed at the end
        yield Generation.of(dictionary, found.best, number, start), _unique([*ranking, *plain])

        tuned = tune_constants(
            dictionary, found.front, fitness, partners, known, smooth=genetics.smooth
        )
        if number == 1:  # beside the leaves first: of nearly equal terms the earlier stays
            tuned = [*tune_beside(dictionary, leaves), *tuned]
        survivors = _unique([*tuned, *ranking, *leaves])
        population = vary(dictionary.terms, fitness, best, genetics, operators, settings)


def first_population(
    first: Problem,
    genetics: Genetics,
    operators: Sequence[Operator],
    settings: Settings,
    leaves: Sequence[Product],
    begin: Sequence[Product],
) -> list[Product]:
    """Initialise: the terms to begin with, simple ones with an inner constant, and random ones.

    Where the leaves fit a first sample exactly, as in q' = v, only the first of these are taken.
    """
    if build_dictionary(first, leaves).is_exact:
        return list(begin)
    plain = plain_terms(operators, first.x, few=first.project is not None)
    known = [*leaves, *begin, *plain]
    return [*begin, *plain, *genetics.random_terms(settings.population_size, known)]


def vary(
    parents: Sequence[Product],
    fitness: np.ndarray,
    best: Sequence[Product],
    genetics: Genetics,
    operators: Sequence[Operator],
    settings: Settings,
) -> list[Product]:
    """Make the new population by crossover and mutation, and add products as alternatives."""
    children = genetics.offspring(
        parents,
        fitness,
        settings.population_size,
        crossover_rate=settings.crossover_rate,
        mutation_rate=settings.mutation_rate,
    )
    return children + product_alternatives(best, operators)


def _sorted(dictionary: Dictionary, fitness: np.ndarray) -> list[Product]:
    return [dictionary.terms[j] for j in np.argsort(fitness, kind="stable")]


def _unique(terms: Sequence[Product]) -> tuple[Product, ...]:
    return tuple(dict.fromkeys(terms))
