"""Trace a residual: which effects, fitted together with the model, predict held-out data better.

Inside the training data, each fold of segments is predicted from the others; where there are
several records, a fold is made of whole records, so that an effect must transfer. The score of an
effect is log(error without it / error with it), where an error is the sum of squares over the
folds: 0 is no gain, 0.7 halves the error variance. Pairs of effects are scored as well, per effect,
because some only show together: friction and drag, whose sum the viscous damping had absorbed.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from ...checks import TINY
from ...terms import Sum
from ..effects.candidate import Candidate
from ..fitting.linear import errors_of, solve_many, summed
from ..given.rows import MAX_TERM_VALUE
from .pairing import groups_to_try, posing_as_offset
from .ranking import Ranking, values_of

Judge = Callable[[np.ndarray], np.ndarray]  # columns of models to their errors in each fold

MIN_RELATIVE_ERROR = 1e-16  # least error, relative to the square of the target
MIN_NEW_SHARE = 1e-6  # share of a column's square that a model must leave for it to be new
IDLE = 0.05  # of what an effect gains beside its offset: an offset that gains less is not needed


def fold_errors(grams: np.ndarray, models: np.ndarray, folds: np.ndarray) -> np.ndarray:
    """Predict each fold of segments from the others.

    Parameters
    ----------
    grams : ndarray of shape (n_segments, p + 1, p + 1)
        Inner products, target last.
    models : ndarray of int of shape (n_models, n_columns)
        Columns of each model.
    folds : ndarray of int of shape (n_segments,)
        Fold of each segment, from 0.

    Returns
    -------
    ndarray of shape (n_models, n_folds)
        Sum of squared errors in each fold.
    """
    models = np.asarray(models, dtype=int)  # a model without columns is an empty list of floats
    used, places = np.unique(models, return_inverse=True)  # sums over all columns take longer
    used = np.append(used, grams.shape[-1] - 1)
    return _judge_of(grams[:, used[:, None], used], folds)(places.reshape(models.shape))


def _judge_of(grams: np.ndarray, folds: np.ndarray) -> Judge:
    held = summed(grams, folds)
    # Not total minus fold: for a column that is zero elsewhere, rounding would be left.
    before, after = (np.cumsum(sums, axis=0) for sums in (held, held[::-1]))
    rest = np.zeros_like(held)
    rest[1:] += before[:-1]
    rest[:-1] += after[-2::-1]
    # Errors below rounding do not compare, and their ratios would overflow.
    floor = MIN_RELATIVE_ERROR * held[:, -1, -1]
    return lambda models: np.maximum(errors_of(rest, held, models), floor)


def rank(
    grams: np.ndarray,
    n_fixed: int,
    candidates: Sequence[Candidate],
    present: set[tuple[int, Sum]],
    folds: np.ndarray,
    *,
    pairs: bool = True,
) -> Ranking:
    """Score all candidates and all pairs of them, best first.

    Parameters
    ----------
    grams : ndarray of shape (n_segments, p + 1, p + 1)
        Inner products of the model's columns, the candidates' columns in order, and the target.
    n_fixed : int
        Number of columns of the model.
    candidates : sequence of Candidate
        What may be missing.
    present : set of (int, Sum)
        Equation and expression of each term of the model; parents must be among them, or in the
        group.
    folds : ndarray of int of shape (n_segments,)
        Fold of each segment.
    pairs : bool
        Whether to score pairs too.

    Returns
    -------
    Ranking
        Candidates that are linear combinations of the model's columns are left out.
    """
    return ranked(
        _judge_of(grams, folds), grams.sum(axis=0), n_fixed, candidates, present, pairs=pairs
    )


def ranked(
    judge: Judge,
    total: np.ndarray,
    n_fixed: int,
    candidates: Sequence[Candidate],
    present: set[tuple[int, Sum]],
    *,
    pairs: bool = True,
) -> Ranking:
    """Score all candidates and all pairs of them, best first.

    Parameters
    ----------
    judge : callable
        Maps the columns of models, (n_models, n_columns), to their errors, (n_models, n_folds).
    total : ndarray of shape (p + 1, p + 1)
        Inner products of all columns, target last.
    n_fixed, candidates, present, pairs
        As in `rank`.

    Returns
    -------
    Ranking
    """
    columns = _columns_of(candidates, n_fixed)
    fresh = are_new(total[:-1, :-1], n_fixed)
    new = [i for i, places in enumerate(columns) if all(fresh[k - n_fixed] for k in places)]
    groups = groups_to_try(candidates, new, present, pairs=pairs)
    errors_of_groups = partial(_errors, judge, n_fixed)
    base_error = judge(np.arange(n_fixed)[None, :])[0]
    lacking = posing_as_offset(candidates, new, present)
    offset_free = _needing_no_offset(partial(errors_of_groups, columns), base_error, lacking)
    # An effect that lacks only an offset is tried beside it, or without it if it needs none: then
    # as a candidate of its own at the end.
    if pairs:
        beside = [(i, k) for i, k in lacking if k not in offset_free]
        groups += [(i, k) for i, k in beside if candidates[k].never_paired]  # others are pairs
    tried = [*candidates, *(candidates[i].needing_no_offset() for i in offset_free)]
    columns += [columns[i] for i in offset_free]
    groups += [(place,) for place in range(len(candidates), len(tried))]
    return Ranking(tried, columns, groups, base_error, errors_of_groups(columns, groups))


def _errors(
    judge: Judge,
    n_fixed: int,
    by_candidate: Sequence[tuple[int, ...]],
    groups: Sequence[tuple[int, ...]],
) -> np.ndarray:
    """Solve all groups with equally many columns at once; errors are (n_groups, n_folds)."""
    columns = [
        by_candidate[g[0]] + by_candidate[g[1]] if len(g) == 2 else by_candidate[g[0]]
        for g in groups
    ]
    sizes = np.array([len(group_columns) for group_columns in columns], dtype=int)
    found: list[tuple[np.ndarray, np.ndarray]] = []
    for size in np.unique(sizes).tolist():
        at = np.flatnonzero(sizes == size)
        fixed = np.broadcast_to(np.arange(n_fixed), (len(at), n_fixed))
        found.append((at, judge(np.hstack([fixed, [columns[k] for k in at.tolist()]]))))
    n_folds = found[0][1].shape[1] if found else 0
    errors = np.empty((len(groups), n_folds))
    for at, part in found:
        errors[at] = part
    return errors


def _needing_no_offset(
    errors: Callable[[Sequence[tuple[int, ...]]], np.ndarray],
    base_error: np.ndarray,
    lacking: Sequence[tuple[int, int]],
) -> list[int]:
    """Return the effects that could pose as an offset, but need none beside them.

    `base_error` is that of the model alone. A true offset would gain beside the effect; if it gains
    nothing, the effect is tried without.
    """
    if not lacking:
        return []
    alone = sorted({place for pair in lacking for place in pair})
    groups = [*((place,) for place in alone), *lacking]
    values = values_of(base_error, errors(groups), groups).tolist()
    gains = {group: value * len(group) for group, value in zip(groups, values, strict=True)}
    return [
        effect
        for offset, effect in lacking
        if gains[offset, effect] - gains[effect,] < IDLE * (gains[offset, effect] - gains[offset,])
    ]


def _columns_of(candidates: Sequence[Candidate], n_fixed: int) -> list[tuple[int, ...]]:
    """Return the columns of each candidate, which come after the fixed ones in their order."""
    ends = n_fixed + np.cumsum([candidate.n_columns for candidate in candidates], dtype=int)
    sizes = [candidate.n_columns for candidate in candidates]
    return [tuple(range(e - n, e)) for e, n in zip(ends.tolist(), sizes, strict=True)]


def are_new(gram: np.ndarray, n_fixed: int) -> np.ndarray:
    """Tell which columns are finite and no combinations of the first `n_fixed` ones.

    Parameters
    ----------
    gram : ndarray of shape (p, p)
        Inner products of the columns.
    n_fixed : int
        Columns of the model.

    Returns
    -------
    ndarray of bool of shape (p - n_fixed,)
    """
    size, beside = np.diagonal(gram)[n_fixed:], gram[:n_fixed, n_fixed:]
    with np.errstate(over="ignore", invalid="ignore"):
        fits = solve_many(gram[:n_fixed, :n_fixed], beside)
        left = size - np.sum(fits * beside, axis=0)
        repeated = left <= MIN_NEW_SHARE * size
    return np.asarray((size > TINY) & (size < MAX_TERM_VALUE**2) & ~repeated)
