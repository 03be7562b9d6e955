"""Trace a residual: which effects, refitted together with the model, better what is held out.

Inside the training data, each fold of segments is predicted from the others; where there are
several records, a fold is made of whole records, so that an effect must transfer. The score of an
effect is log(error without it / error with it), where an error is the sum of squares over the
folds: 0 is no gain, 0.7 halves the error variance. Pairs of effects are scored as well, per effect,
because some only show together: friction and drag, whose sum the viscous damping had absorbed.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import combinations

import numpy as np

from ...checks import TINY
from ...terms import Sum
from ..effects.candidate import EVOLVED, OFFSET, Candidate
from ..fitting.linear import errors_of, solve_many, summed
from ..given.rows import LARGEST

__all__ = ["Score", "are_new", "fold_errors", "rank", "ranked"]

ROUNDING = 1e-16  # relative to the square of the target
NEW = 1e-6  # share of a column's square that the model's columns must leave
IDLE = 0.05  # of what an effect gains beside its offset: an offset that gains less is not needed


@dataclass(frozen=True, eq=False)
class Score:
    """How a group of one or two candidates did: errors of each fold without and with it.

    Its value is log(error without / error with), per effect of the group.
    """

    group: tuple[Candidate, ...]
    places: tuple[int, ...]
    without: np.ndarray
    errors: np.ndarray
    value: float


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
    held = summed(grams, folds)
    # Not the sum of all less this one: a column that is zero elsewhere would leave its rounding.
    rest = np.array([np.delete(held, k, axis=0).sum(axis=0) for k in range(len(held))])
    # Below rounding one fit is not better than another, and ratios of errors would overflow.
    return np.maximum(errors_of(rest, held, models), ROUNDING * held[:, -1, -1])


def rank(
    grams: np.ndarray,
    n_fixed: int,
    candidates: Sequence[Candidate],
    present: set[tuple[int, Sum]],
    folds: np.ndarray,
    *,
    pairs: bool = True,
) -> list[Score]:
    """Score all candidates and all pairs of them, best first.

    Parameters
    ----------
    grams : ndarray of shape (n_segments, p + 1, p + 1)
        Columns of the model, columns of the candidates in their order, target.
    n_fixed : int
        Number of columns of the model.
    candidates : sequence of Candidate
        What may be missing.
    present : set of (int, Sum)
        Equation and expression of what stands in the model; parents must be in it, or in the
        group.
    folds : ndarray of int of shape (n_segments,)
        Fold of each segment.
    pairs : bool
        Whether to score pairs too.

    Returns
    -------
    list of Score
        Candidates that are linear combinations of the model's columns are left out.
    """
    judge = partial(fold_errors, grams, folds=folds)
    return ranked(judge, grams.sum(axis=0), n_fixed, candidates, present, pairs=pairs)


def ranked(
    judge: Callable[[np.ndarray], np.ndarray],
    total: np.ndarray,
    n_fixed: int,
    candidates: Sequence[Candidate],
    present: set[tuple[int, Sum]],
    *,
    pairs: bool = True,
) -> list[Score]:
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
    list of Score
    """
    without = judge(np.arange(n_fixed)[None, :])[0]
    own, start = [], n_fixed
    for candidate in candidates:
        own.append(tuple(range(start, start + candidate.n_columns)))
        start += candidate.n_columns
    fresh = are_new(total[:-1, :-1], n_fixed)
    new = [i for i, columns in enumerate(own) if all(fresh[k - n_fixed] for k in columns)]
    groups: list[tuple[int, ...]] = [(i,) for i in new]
    paired = [i for i in new if pairs and not candidates[i].alone]
    groups += [
        (i, j)
        for i, j in combinations(paired, 2)
        if candidates[i].name != candidates[j].name or candidates[i].name == EVOLVED
    ]
    missing = [{(c.state, parent) for parent in c.parents} - present for c in candidates]
    brought = [{(c.state, term) for term in c.terms} for c in candidates]
    needs = [lacks - terms for lacks, terms in zip(missing, brought, strict=True)]
    allowed = [g for g in groups if all(_is_met(needs[i], i, g, brought) for i in g)]
    offsets = {candidates[i].state: i for i in new if candidates[i].terms == (OFFSET,)}
    posing = [i for i in new if candidates[i].parents == (OFFSET,) and missing[i]]
    lacking = [(offsets[candidates[i].state], i) for i in posing if candidates[i].state in offsets]
    scorer = partial(_scored, judge, n_fixed, candidates, own, without=without)
    scores = [*scorer(allowed), *_without_offset(scorer, candidates, lacking)]
    return sorted(scores, key=lambda score: -score.value)


def _without_offset(
    scorer: Callable[[Sequence[tuple[int, ...]]], list[Score]],
    candidates: Sequence[Candidate],
    pairs: Sequence[tuple[int, int]],
) -> list[Score]:
    """Score effects by themselves that could pose as an offset, but need none beside them.

    `pairs` are the places of an offset and of such an effect. An offset that is really there would
    gain beside the effect; one that gains nothing must not stand in its way.
    """
    places = {place for pair in pairs for place in pair}
    scores = scorer([*((i,) for i in places), *pairs])
    gains = {score.group: score.value * len(score.group) for score in scores}
    free = []
    for offset, effect in ((candidates[i], candidates[j]) for i, j in pairs):
        both, alone = gains[offset, effect], gains[effect,]
        if both - alone < IDLE * (both - gains[offset,]):
            score = next(score for score in scores if score.group == (effect,))
            free.append(replace(score, group=(replace(effect, parents=()),)))
    return free


def _scored(
    judge: Callable[[np.ndarray], np.ndarray],
    n_fixed: int,
    candidates: Sequence[Candidate],
    own: Sequence[tuple[int, ...]],
    groups: Sequence[tuple[int, ...]],
    without: np.ndarray,
) -> list[Score]:
    """Solve all groups with equally many columns at once."""
    base = tuple(range(n_fixed))
    models: dict[int, list[tuple[tuple[int, ...], tuple[int, ...]]]] = {}
    for group in groups:
        columns = sum((own[i] for i in group), ())
        models.setdefault(len(columns), []).append((group, columns))
    scores = []
    for entries in models.values():
        errors = judge(np.array([base + columns for _, columns in entries]))
        before, after = (np.maximum(e.sum(axis=-1), TINY) for e in (without, errors))
        values = (np.log(before) - np.log(after)) / np.array([len(group) for group, _ in entries])
        scores += [
            Score(tuple(candidates[i] for i in group), columns, without, error, value)
            for (group, columns), error, value in zip(entries, errors, values.tolist(), strict=True)
        ]
    return scores


def _is_met(
    needs: set[tuple[int, Sum]],
    place: int,
    group: Sequence[int],
    brought: Sequence[set[tuple[int, Sum]]],
) -> bool:
    """Tell whether the other effect of a group, if there is one, brings what one needs."""
    return not needs or any(needs <= brought[other] for other in group if other != place)


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
        repeated = left <= NEW * size
    return np.asarray((size > TINY) & (size < LARGEST**2) & ~repeated)
