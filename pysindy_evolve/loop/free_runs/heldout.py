"""Held-out errors of free runs: each fold of stretches predicted by a model fitted to the others.

Where a model has met its target as well as it can, what its runs owe to small changes of the
coefficients is linear. So leaving out stretches, and other targets close by, cost a few inner
products, and no other run.

======  ==============================================  ======================================
symbol  shape                                           meaning
======  ==============================================  ======================================
signs   (n_draws, n_stretches)                          by which the noise is multiplied
grams   (n_stretches, p + 2, p + 2)                     of columns, target without noise, noise
======  ==============================================  ======================================
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...checks import TINY
from ..evidence.trace import are_new
from ..fitting.linear import solve_many
from ..fitting.trial import Trial
from .whitening import Whitener

__all__ = ["HeldOut"]


@dataclass(frozen=True, eq=False)
class HeldOut:
    """Inner products of a trial, in which the best starts are taken each time."""

    grams: np.ndarray
    folds: np.ndarray

    @classmethod
    def of(
        cls, trial: Trial, noise: np.ndarray | None = None, whitener: Whitener | None = None
    ) -> HeldOut | None:
        """Look at a trial about its coefficients.

        Parameters
        ----------
        trial : Trial
            A model that has been fitted to its target.
        noise : ndarray of shape (n_stretches, n, n_states), optional
            What is added to the target after multiplication by signs.
        whitener : Whitener, optional
            Leaves what is new in each row only.

        Returns
        -------
        HeldOut or None
            None if the runs diverge or forget how they began.
        """
        rows = trial.rows() if np.isfinite(trial.error) else None
        if rows is None or not np.isfinite(rows.response).all():
            return None
        target = rows.response @ trial.coef[:, None] + rows.of(trial.miss)
        added = np.zeros_like(target) if noise is None else rows.of(noise)
        every, basis = np.concatenate([rows.response, target, added], axis=2), rows.basis
        if whitener is not None:
            every, (basis, _) = whitener(every), np.linalg.qr(whitener(basis))
        every = every - basis @ (np.swapaxes(basis, 1, 2) @ every)
        return cls(np.swapaxes(every, 1, 2) @ every, trial.part.folds)

    def errors(self, signs: np.ndarray, columns: Sequence[int] | None = None) -> np.ndarray:
        """Return the sum of squared held-out errors for each draw of signs, shape (n_draws,)."""
        p = self.grams.shape[1] - 2
        used = np.arange(p) if columns is None else np.asarray(columns, dtype=int)
        index = np.array([*used, p, p + 1])
        grams, p = self.grams[:, index[:, None], index], len(used)
        total = np.zeros(len(signs))
        for fold in range(int(self.folds.max()) + 1):
            held = self.folds == fold
            rest = grams[~held]
            xy = rest[:, :p, p].sum(axis=0) + signs[:, ~held] @ rest[:, :p, p + 1]
            coef = solve_many(rest[:, :p, :p].sum(axis=0), xy.T).T
            for gram, sign in zip(grams[held], signs[:, held].T, strict=True):
                left = np.column_stack([coef, -np.ones(len(signs)), -sign])
                total += np.sum((left @ gram) * left, axis=1)
        return np.maximum(total, TINY)

    def is_new(self, own: int, columns: Sequence[int]) -> bool:
        """Tell whether columns are finite and no combinations of the first `own` ones."""
        index = np.array([*range(own), *columns])
        total = self.grams[:, index[:, None], index].sum(axis=0)
        return bool(are_new(total, own).all())
