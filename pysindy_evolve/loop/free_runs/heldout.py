"""Held-out errors of free runs: each fold of stretches predicted by a model fitted to the others.

Around a converged fit, the runs are linear in small changes of the coefficients. So errors with a
fold left out, and for other targets close by, take a few inner products and no further run.

======  ==============================================  ======================================
symbol  shape                                           meaning
======  ==============================================  ======================================
signs   (n_draws, n_stretches)                          factors of the noise, 1 or -1
grams   (n_stretches, p + 2, p + 2)                     of columns, target without noise, noise
======  ==============================================  ======================================
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...checks import TINY
from ..evidence.held_out_scores import are_new
from ..fitting.linear import solve_many
from ..fitting.trial import Trial
from .whitening import Whitener


@dataclass(frozen=True, eq=False)
class HeldOut:
    """Inner products of a linearized trial, the initial states of its runs projected out."""

    grams: np.ndarray
    folds: np.ndarray

    @classmethod
    def of(
        cls, trial: Trial, noise: np.ndarray | None = None, whitener: Whitener | None = None
    ) -> HeldOut | None:
        """Linearize a trial about its coefficients.

        Parameters
        ----------
        trial : Trial
            A model that has been fitted to its target.
        noise : ndarray of shape (n_stretches, n, n_states), optional
            Added to the target, times the sign of each stretch.
        whitener : Whitener, optional
            Removes from each row what earlier rows predict.

        Returns
        -------
        HeldOut or None
            None if the runs diverge, or small deviations grow too fast along them.
        """
        rows = trial.rows() if np.isfinite(trial.error) else None
        if rows is None or not np.isfinite(rows.response).all():
            return None
        target = rows.response @ trial.coef[:, None] + rows.of(trial.miss)
        noise_rows = np.zeros_like(target) if noise is None else rows.of(noise)
        all_columns, basis = np.concatenate([rows.response, target, noise_rows], axis=2), rows.basis
        if whitener is not None:
            all_columns, (basis, _) = whitener(all_columns), np.linalg.qr(whitener(basis))
        all_columns = all_columns - basis @ (np.swapaxes(basis, 1, 2) @ all_columns)
        return cls(np.swapaxes(all_columns, 1, 2) @ all_columns, trial.part.folds)

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
                contrast = np.column_stack([coef, -np.ones(len(signs)), -sign])
                total += np.sum((contrast @ gram) * contrast, axis=1)
        return np.maximum(total, TINY)

    def is_new(self, own: int, columns: Sequence[int]) -> bool:
        """Tell whether columns are finite and linearly independent of the first `own` ones."""
        index = np.array([*range(own), *columns])
        total = self.grams[:, index[:, None], index].sum(axis=0)
        return bool(are_new(total, own).all())
