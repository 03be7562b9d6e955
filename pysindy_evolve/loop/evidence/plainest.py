"""Of effects that do equally well, the plainest: it is named, and tested on twins."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..effects.candidate import OFFSET, Candidate
from ..effects.names import order_of
from .ranking import Score
from .scoring import MIN_GAIN_LOG
from .shares import Shares

EQUAL = 0.99  # share of the best score: enough to do as well
ONE_PERCENT = 0.01  # of the largest gain in log error: within it, gains are as good
NEARLY_ALL = 0.98  # share of what a term with a number removes: enough to prefer one without


def is_as_good(error: float, other: float) -> bool:
    """Tell whether an error is no larger than another one, but for what changes no name."""
    return bool(error <= np.exp(MIN_GAIN_LOG) * other)


def as_good_as_best(gains: Sequence[float] | np.ndarray) -> list[int]:
    """Return the places of the gains in log error that are as good as the largest."""
    best = float(np.max(gains))
    if np.isinf(best):  # no error is left, or each one is infinite
        return [place for place, gain in enumerate(gains) if gain == best]
    enough = best - max(MIN_GAIN_LOG, ONE_PERCENT * best)
    return [place for place, gain in enumerate(gains) if gain >= enough]


def plainest(scores: Sequence[Score]) -> Score:
    """Return the smallest of the groups that do as well as the first, to one percent.

    Of equally small ones, that in fewer equations, then that with fewer variables, and then the
    first in the vocabulary.
    """
    equal = [
        s
        for s in scores
        if s.value >= EQUAL * scores[0].value and len(s.group) == len(scores[0].group)
    ]

    def plainness(score: Score) -> tuple[int, int, int, int]:
        n_partners = sum(len(candidate.partners) for candidate in score.group)
        size = sum(candidate.size for candidate in score.group)
        n_variables = sum(len(term.variables) for one in score.group for term in one.terms)
        order = sum(order_of(candidate.name) for candidate in score.group)
        return size, n_partners, n_variables, order

    return min(equal, key=plainness)


def without_number(best: Score, worthy: Sequence[Score], shares: Shares) -> Score:
    """Return a term without a number if it removes nearly as much as the best, with a number.

    A saturation that is hardly reached is a gain; what it does better may be ringing of a filter.
    """
    (candidate, *more) = best.group
    if more or candidate.shape is None:
        return best
    enough = NEARLY_ALL * shares.of(best)
    return next((s for s in worthy if _is_plainer(s, candidate) and shares.of(s) >= enough), best)


def _is_plainer(score: Score, candidate: Candidate) -> bool:
    """Tell whether a group is an effect of the same variables, smaller and without a number.

    It may have an offset beside it, or be one, if the effect with a number contains an offset.
    """
    if any(c.state != candidate.state or c.shape is not None for c in score.group):
        return False
    group = [c for c in score.group if not (candidate.contains_parents and c.terms == (OFFSET,))]
    if len(group) > 1:
        return False
    return all(c.variables == candidate.variables and c.size < candidate.size for c in group)
