"""Algorithm 1 of the paper: the only loop over generations.

======  ====================  ========================================================
symbol  shape                 meaning
======  ====================  ========================================================
x       (n, n_variables)      states and inputs
target  (n,)                  what the equation must give: one column of x_dot
theta   (m, p)                dictionary on the m rows of a sample, columns of unit RMS
======  ====================  ========================================================

Initialise a population of terms; then, each generation: build the dictionary, solve the elastic
net, rate the terms (fitness, lower is better), vary them. What survives is kept beside the
population, so a good term waits for its partners.
"""

from __future__ import annotations

import time
import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from tqdm.auto import tqdm

from . import regression
from .constants import tune
from .dictionary import Dictionary, Problem, Project, build_dictionary, price, skeleton
from .genetics import Genetics
from .operators import Operator
from .terms import ONE, Product, Variable

__all__ = ["Evolution", "Generation", "Settings", "evolve"]

ROWS = 3000  # rows that a generation is scored on; the final refit sees all of them
FINALISTS = 24  # terms that are weighed against each other on all rows
N_TUNED = 3  # terms a generation whose inner constants are tuned, best first
N_BLOCKS = 12  # parts of the record that a coefficient must agree on
PERFECT = 1e-11  # share of the target's power at which there is nothing left to explain


@dataclass(frozen=True)
class Settings:
    """Parameters of the search, named as in `EvolvingLibrary`."""

    population_size: int = 80
    n_generations: int = 30
    crossover_rate: float = 0.9
    mutation_rate: float = 0.1
    max_depth: int = 4
    max_terms: int = 12
    patience: int = 10


@dataclass(frozen=True)
class Generation:
    """What one generation found.

    Parameters
    ----------
    number : int
        Counted from one.
    terms : tuple of Product
        The best equation, without coefficients.
    coef : tuple of float
        Its coefficients, in units of the target per unit of the term.
    fitness : float
        Mean square error of the best equation, as a share of the mean square of the target.
    time : float
        Seconds since the search began.
    """

    number: int
    terms: tuple[Product, ...]
    coef: tuple[float, ...]
    fitness: float
    time: float

    @property
    def n_terms(self) -> int:
        """Number of terms of the best equation."""
        return len(self.terms)


@dataclass(frozen=True)
class Evolution:
    """Result of a search.

    Parameters
    ----------
    terms : tuple of Product
        Terms of the equation, found on top of the fixed columns.
    coef : tuple of float
        Their coefficients, least squares on all rows, in units of the target per unit of term.
    history : tuple of Generation
        One record for each generation.
    """

    terms: tuple[Product, ...]
    coef: tuple[float, ...]
    history: tuple[Generation, ...]


def evolve(
    x: np.ndarray,
    target: np.ndarray,
    *,
    operators: Sequence[Operator],
    rng: np.random.Generator,
    fixed: np.ndarray | None = None,
    project: Project | None = None,
    settings: Settings | None = None,
    progress: bool = False,
) -> Evolution:
    """Grow the terms of one equation: target = fixed @ a + theta @ coef.

    Parameters
    ----------
    x : ndarray of shape (n, n_variables)
        Variables, in the user's units.
    target : ndarray of shape (n,)
        What the equation must give.
    operators : sequence of Operator
        Basis functions.
    rng : numpy.random.Generator
        Source of all randomness.
    fixed : ndarray of shape (n, n_fixed), optional
        Columns that are always in the equation; terms are grown on top of them.
    project : callable, optional
        A linear map on the rows of columns, (n, p) to (m, p), applied to theta, fixed columns and
        target alike, such as smooth windows. All rows are then used in each generation.
    settings : Settings, optional
        Parameters of the search.
    progress : bool
        Show a progress bar.

    Returns
    -------
    Evolution

    Notes
    -----
    A generation costs a fixed number of rows, whatever n is. The search ends after
    ``n_generations``, or when the equation has not changed for ``patience`` of them, or when
    nothing is left to explain. Ctrl-C ends it with the best equation so far.
    """
    settings = settings or Settings()
    fixed = np.empty((len(x), 0)) if fixed is None else fixed
    problem = Problem(x, target, fixed, project)
    history: list[Generation] = []
    finalists: tuple[Product, ...] = ()
    search = generations(problem, operators, settings, rng)
    bar = tqdm(search, total=settings.n_generations, disable=not progress, desc="generation")
    try:
        for generation, finalists in bar:
            history.append(generation)
            bar.set_postfix(n_terms=generation.n_terms, fitness=f"{generation.fitness:.3g}")
            if _settled(history, settings.patience):
                break
    except KeyboardInterrupt:
        warnings.warn(
            f"The search was interrupted after {len(history)} generations; "
            "the best equation so far is kept.",
            stacklevel=2,
        )
    finally:
        bar.close()
    terms, coef = refit(problem, finalists, history[-1].n_terms if history else 0, settings)
    return Evolution(terms, coef, tuple(history))


def generations(
    problem: Problem, operators: Sequence[Operator], settings: Settings, rng: np.random.Generator
) -> Iterator[tuple[Generation, tuple[Product, ...]]]:
    """Algorithm 1. Yield each generation's record, and the terms to weigh on all rows."""
    start = time.perf_counter()
    genetics = Genetics(operators, _typical(problem.x), max_depth=settings.max_depth, rng=rng)
    leaves = (ONE, *(Product(((Variable(i), 1),)) for i in range(problem.x.shape[1])))

    survivors: tuple[Product, ...] = leaves
    population = genetics.random_terms(settings.population_size, known=leaves)
    for number in range(1, settings.n_generations + 1):
        sample = problem.sample(ROWS, rng)
        dictionary = build_dictionary(sample, [*survivors, *population])
        support, n_effective = solve_elastic_net(dictionary, survivors, settings.max_terms)
        fitness = rate(dictionary, support, n_effective)

        ranking = _ranking(dictionary, support, fitness)
        yield _record(dictionary, support, number, start), ranking[:FINALISTS]
        tuned = tune_constants(dictionary, support, ranking)
        survivors = _unique([*tuned, *ranking[:FINALISTS], *leaves])
        population = genetics.offspring(
            dictionary.terms,
            fitness,
            settings.population_size,
            crossover_rate=settings.crossover_rate,
            mutation_rate=settings.mutation_rate,
        )


def solve_elastic_net(
    dictionary: Dictionary, survivors: Sequence[Product], max_terms: int
) -> tuple[np.ndarray, float]:
    """Find the best equation that the dictionary holds.

    The elastic net proposes supports, along with what survived; each is pruned by the information
    criterion, first as if rows were independent, then for as many rows as the residual shows.
    """
    gram, terms = dictionary.gram, dictionary.terms
    known = {term: j for j, term in enumerate(terms)}
    old = np.array([known[t] for t in survivors if t in known], dtype=int)
    proposals = [*regression.supports(gram, 2 * max_terms), old]
    support, n_effective = np.arange(0), float(gram.n)
    for _ in range(2):
        cost = price(terms, n_effective)
        pruned = [regression.prune(gram, s, cost, n_effective) for s in proposals]
        support = min(pruned, key=lambda s: regression.information(gram, s, cost, n_effective))
        n_effective = regression.effective_size(dictionary.residual(support))
    return support, n_effective


def rate(dictionary: Dictionary, support: np.ndarray, n_effective: float) -> np.ndarray:
    """Fitness of each term, lower is better.

    It is the mean square error with the term in the best equation against that without it, as
    the change of the information criterion n log(MSE) + price.
    """
    gram = dictionary.gram
    scaled = gram.scaled(gram.scale)
    with_term, without_term = regression.gains(scaled, support)
    change = n_effective * np.log(with_term / without_term)
    return change + price(dictionary.terms, n_effective)


def tune_constants(
    dictionary: Dictionary, support: np.ndarray, ranking: Sequence[Product]
) -> list[Product]:
    """Tune the inner constants of the best terms that have some, each beside the equation."""
    problem, n_fixed = dictionary.problem, dictionary.n_fixed
    members = [dictionary.terms[j] for j in support]
    tuned = []
    for term in [term for term in ranking if term.constants][:N_TUNED]:
        beside = [n_fixed + j for j, t in zip(support, members, strict=True) if t != term]
        others = dictionary.theta[:, [*range(n_fixed), *beside]]
        tuned += tune([term], problem.x, dictionary.y, others, project=problem.project)
    return tuned


def refit(
    problem: Problem, finalists: Sequence[Product], n_best: int, settings: Settings
) -> tuple[tuple[Product, ...], tuple[float, ...]]:
    """Weigh the finalists against each other on all rows and refit by least squares.

    The first `n_best` finalists are the equation so far. A term stays if it pays its price on all
    rows and if its coefficient is the same all along the record.
    """
    terms = [*_tuned_together(problem, finalists[:n_best]), *finalists[n_best:]]
    n_fixed, n_blocks = problem.fixed.shape[1], N_BLOCKS
    blocks = problem.blocks(terms, n_blocks)
    whole = regression.total(blocks)
    finite = np.flatnonzero(np.isfinite(np.diag(whole.xx)[n_fixed:]))
    terms = [terms[j] for j in finite]
    columns, scale = np.r_[np.arange(n_fixed), n_fixed + finite], 1.0
    whole = whole.select(columns)
    scale = whole.scale
    folds = [(whole - b.select(columns)).scaled(scale).without(n_fixed) for b in blocks]
    whole = whole.scaled(scale).without(n_fixed)
    scale = scale[n_fixed:]

    support, n_effective = np.arange(len(terms)), float(whole.n)
    for _ in range(2):
        cost = price(terms, n_effective)
        support = regression.prune(
            whole, np.arange(len(terms)), cost, n_effective, settings.max_terms
        )
        n_effective = regression.effective_size(_residual(problem, [terms[j] for j in support]))
    support = regression.stable(whole, folds, support)
    coef = regression.least_squares(whole, support)[support] / scale[support]
    return tuple(terms[j] for j in support), tuple(float(c) for c in coef)


def _residual(problem: Problem, terms: Sequence[Product]) -> np.ndarray:
    theta, y = problem.regression(terms)
    gram = regression.gram(theta, y)
    return y - theta @ regression.least_squares(gram, np.arange(theta.shape[1]))


def _tuned_together(problem: Problem, terms: Sequence[Product]) -> Sequence[Product]:
    if not any(term.constants for term in terms):
        return terms
    sample = problem.sample(4 * ROWS, np.random.default_rng(0))
    free = [term for term in terms if term.constants]
    rest, y = sample.regression([term for term in terms if not term.constants])
    found = dict(zip(free, tune(free, sample.x, y, rest, project=sample.project), strict=True))
    return [found.get(term, term) for term in terms]


def _ranking(
    dictionary: Dictionary, support: np.ndarray, fitness: np.ndarray
) -> tuple[Product, ...]:
    order = [*support, *np.argsort(fitness, kind="stable")]
    return _unique([dictionary.terms[j] for j in order])


def _record(dictionary: Dictionary, support: np.ndarray, number: int, start: float) -> Generation:
    gram, scale = dictionary.gram, dictionary.scale
    coef = regression.least_squares(gram, support)
    power = max(float(dictionary.y @ dictionary.y), np.finfo(float).tiny)
    return Generation(
        number,
        tuple(dictionary.terms[j] for j in support),
        tuple(float(c) for c in coef[support] / scale[support]),
        regression.rss(gram, coef) / power,
        time.perf_counter() - start,
    )


def _settled(history: Sequence[Generation], patience: int) -> bool:
    """Tell whether the search has stopped to find anything."""
    last = history[-1]
    if last.fitness <= PERFECT:
        return True
    recent = {frozenset(map(skeleton, g.terms)) for g in history[-patience - 1 :]}
    return len(history) > patience and len(recent) == 1


def _typical(x: np.ndarray) -> np.ndarray:
    """RMS of each variable; one where a variable is zero."""
    size = np.sqrt(np.mean(np.square(x), axis=0))
    return np.where(size > 0.0, size, 1.0)


def _unique(terms: Sequence[Product]) -> tuple[Product, ...]:
    return tuple(dict.fromkeys(terms))
