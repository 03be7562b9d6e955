"""Gains of effects, best first: log(error without / error with), per effect of a group."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import overload

import numpy as np

from ...checks import TINY
from ..effects.candidate import Candidate


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


class Ranking(Sequence[Score]):
    """Scores, best first; each is made on demand, as few of thousands of pairs are looked at.

    Parameters
    ----------
    candidates : sequence of Candidate
        What was tried.
    columns : sequence of tuple of int
        Columns of each candidate.
    groups : sequence of tuple of int
        Places of the candidates in each group.
    without : ndarray of shape (n_folds,)
        Errors of the model without any of them.
    errors : ndarray of shape (n_groups, n_folds)
        Errors with each group.
    """

    def __init__(
        self,
        candidates: Sequence[Candidate],
        columns: Sequence[tuple[int, ...]],
        groups: Sequence[tuple[int, ...]],
        without: np.ndarray,
        errors: np.ndarray,
    ) -> None:
        self._candidates, self._columns, self._groups = candidates, columns, groups
        self._without, self._errors = without, errors
        self.values = values_of(without, errors, groups)
        self._order = np.argsort(-self.values, kind="stable").tolist()

    def __len__(self) -> int:
        return len(self._order)

    @overload
    def __getitem__(self, place: int) -> Score: ...
    @overload
    def __getitem__(self, place: slice) -> list[Score]: ...
    def __getitem__(self, place: int | slice) -> Score | list[Score]:
        if isinstance(place, slice):
            return [self._score(k) for k in self._order[place]]
        return self._score(self._order[place])

    def _score(self, k: int) -> Score:
        group = self._groups[k]
        return Score(
            tuple(self._candidates[i] for i in group),
            sum((self._columns[i] for i in group), ()),
            self._without,
            self._errors[k],
            float(self.values[k]),
        )


def values_of(
    without: np.ndarray, errors: np.ndarray, groups: Sequence[tuple[int, ...]]
) -> np.ndarray:
    """Return log(error without / error with) of each group, per effect."""
    before, after = (np.maximum(e.sum(axis=-1), TINY) for e in (without, errors))
    n_effects = np.array([len(group) for group in groups], dtype=float)
    return np.asarray((np.log(before) - np.log(after)) / n_effects)
