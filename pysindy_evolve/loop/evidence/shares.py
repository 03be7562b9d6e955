"""How much effects matter, in the derivative and in the simulation, whatever their p-value."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...checks import TINY
from ..effects.candidate import Candidate
from ..fitting.linear import log_ratio, solve
from ..fitting.residual import derivative_grams, jacobian, view_grams
from ..fitting.trajectory import Trajectories
from ..given.design import Design
from ..given.segments import Segments
from .held_out_scores import fold_errors
from .ranking import Score
from .scoring import columns_of, quick_fit

EXACT = 3e-4  # derivative error, in standard deviations, below which no sensor sees a difference


class Shares:
    """The share of the explainable error, as a variance, that the effects of a group remove.

    The explainable error is that of the declared model less that of the model with all candidates.
    Of derivative and simulation the larger share counts: an offset hardly shows in the first, a
    ripple hardly in the second. An effect that adds no term, such as a delay of an input, is
    compared with the error of the present model instead, as it makes no equation longer.
    """

    def __init__(
        self, declared: Design, design: Design, part: Segments, proposed: Sequence[Candidate]
    ) -> None:
        extra = [column for candidate in proposed for column in columns_of(candidate, design)]
        columns = [*design.columns, *extra]
        if part.by_trajectory:
            tracks = Trajectories(part.records, design, columns)
            views = {"simulation": tracks.total(0)[None], "derivative": tracks.total(-1)[None]}
        else:
            slopes = jacobian(quick_fit(design, part), part.z, part.state_scale)
            views = view_grams(part, design, columns, slopes)
        self._grams = {name: grams.sum(axis=0) for name, grams in views.items()}
        self._base = tuple(range(len(design.columns)))
        self._errors: dict[tuple[str, tuple[int, ...]], float] = {}
        every = tuple(range(len(design.columns) + len(extra)))
        self._of_declared, self._of_present = (
            {name: self._left(name, every[:n]) - self._left(name, every) for name in self._grams}
            for n in (len(declared.columns), len(design.columns))
        )

    def of(self, score: Score) -> float:
        """Return the share that the least useful effect of a group removes."""
        return min(self._of_effect(score, k) for k in range(len(score.group)))

    def _of_effect(self, score: Score, k: int) -> float:
        start = sum(candidate.n_columns for candidate in score.group[:k])
        own = score.places[start : start + score.group[k].n_columns]
        exchange = score.group[k].is_exchange
        explainable = self._of_present if exchange else self._of_declared
        others = tuple(place for place in score.places if place not in own)
        return max(
            (self._left(name, self._base + others) - self._left(name, self._base + score.places))
            / max(explainable[name], TINY)
            for name in self._grams
        )

    def _left(self, view: str, columns: tuple[int, ...]) -> float:
        """Return the residual square of columns, computed once, as groups share many."""
        if (view, columns) not in self._errors:
            self._errors[view, columns] = _error(self._grams[view], columns)
        return self._errors[view, columns]


def view_gain(design: Design, group: Sequence[Candidate], part: Segments) -> float:
    """Return log(error without / error with), the larger one of derivative and simulation.

    Each fold of segments is predicted from the others.
    """
    columns = [*design.columns, *(c for one in group for c in columns_of(one, design))]
    slopes = jacobian(quick_fit(design, part), part.z, part.state_scale)
    base, every = np.arange(len(design.columns))[None, :], np.arange(len(columns))[None, :]
    gains = []
    for grams in view_grams(part, design, columns, slopes).values():
        without, with_it = (
            fold_errors(grams, models, part.folds).sum() for models in (base, every)
        )
        gains.append(log_ratio(without, with_it))
    return max(gains)


def is_exact(design: Design, part: Segments) -> bool:
    """Tell whether a design's residual is no larger than errors of differentiation and filters."""
    total = derivative_grams(part, design, design.columns).sum(axis=0)
    n_rows = len(part.z) * part.windows.count(part.z.shape[1]) * len(design.open_states)
    return _error(total, range(len(design.columns))) <= EXACT**2 * max(n_rows, 1)


def _error(gram: np.ndarray, columns: Sequence[int]) -> float:
    """Return the residual square of a least-squares fit to some columns."""
    index = np.asarray(columns, dtype=int)
    explained = solve(gram[np.ix_(index, index)], gram[index, -1]) @ gram[index, -1]
    return float(max(gram[-1, -1] - explained, 0.0))
