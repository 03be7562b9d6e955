"""The last step of the search: the finalists on all rows.

A generation sees some thousand rows; here every row counts, in chunks, so memory does not grow.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np

from ..sparse import parsimony
from ..sparse.gram import Gram, least_squares, residual, rss, total
from ..sparse.parsimony import MIN_ROWS, N_BLOCKS
from ..sparse.proposals import supports
from ..sparse.selection import select
from ..terms import Product, of_term
from .constants import tune
from .dictionary import Problem, price
from .least_power import least_explained_power
from .poles import has_pole, keeps_sign

TUNING_ROWS = 10_000  # for all inner constants together


def refit(
    problem: Problem,
    finalists: Sequence[Product],
    n_best: int,
    max_terms: int,
    perfect: bool = False,
) -> tuple[tuple[Product, ...], tuple[float, ...]]:
    """Weigh the finalists against each other on all rows.

    Parameters
    ----------
    problem : Problem
        All rows.
    finalists : sequence of Product
        Terms to weigh; the first `n_best` are the equation so far.
    n_best : int
        Terms whose inner constants are tuned together first.
    max_terms : int
        Most terms to keep.
    perfect : bool
        Whether the equation so far left nothing on a sample. If it leaves nothing on all rows
        either, no other term is tried.

    Returns
    -------
    terms : tuple of Product
        Terms that pay their price on all rows, keep their coefficient all along the record, and
        explain more than the error of a derivative and the noise in the variables do.
    coef : tuple of float
        Their coefficients by least squares, in units of the target per unit of the term.
    """
    best = _tuned_together(problem, finalists[:n_best])
    is_complete = perfect and _leaves_nothing(problem, best)
    terms = [*best, *([] if is_complete else finalists[n_best:])]
    terms = [term for term, ok in zip(terms, problem.has_values(terms), strict=True) if ok]
    terms = [term for term in terms if not has_pole(of_term(term), problem.x, keeps_sign)]
    terms, whole, folds, scale = _grams(problem, terms)
    if not terms:
        return (), ()
    so_far = np.array([j for j, term in enumerate(terms) if term in best], dtype=int)
    proposals = [*supports(whole, max_terms), np.arange(len(terms)), so_far]
    chosen = select(
        whole,
        proposals,
        partial(price, terms),
        lambda support: _residual(problem, *_equation(terms, whole, support, scale)),
        whole.yy,
        max_terms,
    )
    support = chosen.best
    if folds:
        support = parsimony.drop_unstable(whole, folds, support)
    least = least_explained_power(problem, *_equation(terms, whole, support, scale))
    support = parsimony.drop_immaterial(whole, support, least)
    n_free = np.array([len(term.constants) for term in terms])
    support = parsimony.exchange_for_simpler(whole, support, chosen.cost, n_free)
    kept = sorted(support, key=lambda j: terms[j].size)
    return _equation(terms, whole, kept, scale)


def _equation(
    terms: Sequence[Product], whole: Gram, support: Sequence[int] | np.ndarray, scale: np.ndarray
) -> tuple[tuple[Product, ...], tuple[float, ...]]:
    """Return the terms of a support and their coefficients, in the units of the problem."""
    coef = least_squares(whole, support)[support] / scale[support]
    return tuple(terms[j] for j in support), tuple(float(c) for c in coef)


def _grams(
    problem: Problem, terms: Sequence[Product]
) -> tuple[list[Product], Gram, list[Gram], np.ndarray]:
    """Return the finite terms, the Gram matrices of all rows and of all but each block, and scale.

    Columns have unit RMS on all rows, and the fixed columns are projected out.
    """
    n_fixed = problem.fixed.shape[1]
    n_blocks = max(min(N_BLOCKS, len(problem.x) // MIN_ROWS), 1)
    blocks = problem.blocks(terms, n_blocks)
    whole = total(blocks)
    finite = np.flatnonzero(np.isfinite(np.diag(whole.xx)[n_fixed:]))
    columns = np.r_[np.arange(n_fixed), n_fixed + finite]
    whole, blocks = whole.select(columns), [block.select(columns) for block in blocks]
    scale = whole.scale
    held_out = blocks if n_blocks > 3 else []  # else too few to see scatter
    folds = [(whole - block).scaled(scale).without(n_fixed) for block in held_out]
    kept = [terms[int(j)] for j in finite]
    return kept, whole.scaled(scale).without(n_fixed), folds, scale[n_fixed:]


def _leaves_nothing(problem: Problem, terms: Sequence[Product]) -> bool:
    (whole,) = problem.blocks(terms, 1)
    projected = whole.without(problem.fixed.shape[1])
    coef = least_squares(projected, np.arange(len(projected.xy)))
    return rss(projected, coef) <= parsimony.PERFECT * whole.yy


def _residual(problem: Problem, terms: Sequence[Product], coef: Sequence[float]) -> np.ndarray:
    """Return the residual of an equation, fixed columns included."""
    if problem.project is not None:
        theta, y = problem.regression(terms)
        basis = np.linalg.qr(theta)[0]
        return y - basis @ (basis.T @ y)
    weights = np.asarray(coef)
    if problem.fixed.shape[1]:  # coef leaves them out: solve for all
        (whole,) = problem.blocks(terms, 1)
        weights = least_squares(whole, np.arange(len(whole.xy)))
    return residual(lambda rows: problem.theta(terms, rows), problem.target, weights)


def _tuned_together(problem: Problem, terms: Sequence[Product]) -> Sequence[Product]:
    if not any(term.constants for term in terms):
        return terms
    sample = problem.sample(TUNING_ROWS, np.random.default_rng(0))
    free = [term for term in terms if term.constants]
    rest, y = sample.regression([term for term in terms if not term.constants])
    found = dict(zip(free, tune(free, sample.x, y, rest, project=sample.project), strict=True))
    return [found.get(term, term) for term in terms]
