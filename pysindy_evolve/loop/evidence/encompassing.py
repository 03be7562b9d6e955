"""Which other effects could have left the same record? A confidence set, not a list of runners-up.

Models that are not nested are compared by encompassing: a rival replaces the effect, all
coefficients are refitted, and the effect is offered beside the rival once more. If the rival were
the cause, the effect would gain no more than chance gives to the best of all candidates. A gain
counts in units of its scatter over the pieces of the record, each predicted by the others
(jackknife), because a column that lives on a few loud pieces gains much by chance. The wild cluster
bootstrap says how large the largest ratio is by chance: the residual of the model with both is
multiplied by a random sign in each piece, which keeps the color of the noise and its changes
between pieces. (The residual of the rival alone would contain the effect, and a few loud pieces
could then pass for chance.)

A rival that is not refuted is an alternative. If the cause is among the candidates, it is refuted
with a chance no larger than the level.

References
----------
Mizon and Richard, Econometrica 54 (1986), DOI 10.2307/1911313: encompassing.
Davidson and MacKinnon, Econometrica 49 (1981), DOI 10.2307/1911522: the J test.
Cameron, Gelbach and Miller, Rev. Econ. Stat. 90 (2008), DOI 10.1162/rest.90.3.414: the bootstrap.
MacKinnon, Nielsen and Webb, J. Appl. Econom. 38 (2023), DOI 10.1002/jae.2969: with the jackknife.
Romano and Wolf, Econometrica 73 (2005), DOI 10.1111/j.1468-0262.2005.00615.x: the largest ratio.

======  ==============================================  ======================================
symbol  shape                                           meaning
======  ==============================================  ======================================
grams   (n_segments, n_columns + 1, n_columns + 1)      whitened inner products, target last
free    (n_segments, n_columns + 1, n_kept)             of all with some, the model projected out
slopes  (n_segments, n_columns)                         unit columns times target, after that
shares  (n_segments, n_columns)                         of each column's square, after that
======  ==============================================  ======================================
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...checks import TINY
from ..fitting.linear import solve
from ..twins.chance import draws_for, p_value_of
from .held_out_scores import MIN_NEW_SHARE

N_SIGNS = 999


@dataclass(frozen=True, eq=False)
class Left:
    """What columns of unit size could still explain, segment by segment, beside a model.

    Attributes
    ----------
    slopes : ndarray of shape (n_segments, n_columns)
        Inner products of columns and target, both with the model projected out.
    shares : ndarray of shape (n_segments, n_columns)
        Of the square of such a column; all zero if the column is not new.
    """

    slopes: np.ndarray
    shares: np.ndarray

    def ratios(self, signs: np.ndarray) -> np.ndarray:
        """Return the gains over their jackknifed scatter, for given signs of the segments.

        Parameters
        ----------
        signs : ndarray of shape (n_draws, n_segments)
            Ones and minus ones.

        Returns
        -------
        ndarray of shape (n_draws, n_columns)
            Squares of t-ratios.
        """
        # A fit to the others misses a segment by (slope - share * total) / (1 - share).
        weight = 1.0 / np.maximum(1.0 - self.shares, 1e-6) ** 2
        total = signs @ self.slopes
        mixed = signs @ (weight * self.shares * self.slopes)
        slope_sum, share_sum = (
            np.sum(weight * part**2, axis=0) for part in (self.slopes, self.shares)
        )
        scatter = slope_sum - 2.0 * total * mixed + total**2 * share_sum
        return np.asarray(total**2 / np.maximum(scatter, 1e-9 * slope_sum + TINY))


def chance(
    grams: np.ndarray,
    model: Sequence[int],
    columns: Sequence[int],
    level: float,
    rng: np.random.Generator,
) -> float:
    """Return the chance of gains as clear as those of some columns, if the model were the cause.

    Parameters
    ----------
    grams : ndarray of shape (n_segments, n_columns + 1, n_columns + 1)
        Inner products of all columns, target last.
    model : sequence of int
        Columns of the rival's model.
    columns : sequence of int
        Columns of the effect; their joint gain counts.
    level : float
        So many signs are drawn that a p-value as small as this is possible.
    rng : numpy.random.Generator
        Draws the signs.

    Returns
    -------
    float
    """
    own = list(columns)
    free, shares = _projected(grams, model, [*own, -1])
    left, inner = Left(free[:, :-1, -1], shares[:, :-1]), free[:, own, :-1]
    unsigned = np.ones((1, len(grams)))
    observed = _together(left.slopes[:, own], inner, unsigned)
    others = free[:, own].sum(axis=0) - free[:, own]
    coef = solve(others[..., :-1], others[..., -1])
    explained_slopes = free[:, :-1, :-1] @ coef[:, :, None]
    both = replace(left, slopes=left.slopes - explained_slopes[..., 0])
    signs = rng.choice([-1.0, 1.0], size=(draws_for(level, N_SIGNS), len(grams)))
    largest = both.ratios(signs).max(axis=1)
    if len(own) > 1:
        largest = np.maximum(largest, _together(both.slopes[:, own], inner, signs))
    return p_value_of(float(observed[0]), largest)


def _together(slopes: np.ndarray, inner: np.ndarray, signs: np.ndarray) -> np.ndarray:
    """Return the joint gains of several columns over their jackknifed scatter, (n_draws,).

    For one column they equal `Left.ratios`. Columns that explain only together, such as the sine
    and the cosine of one wave, show nothing alone.
    """
    identity = np.eye(slopes.shape[1])
    shares = inner @ np.linalg.pinv(inner.sum(axis=0), hermitian=True)
    total = signs @ slopes
    missed = signs[:, :, None] * slopes - np.einsum("sij,dj->dsi", shares, total)
    missed = np.einsum("sij,dsj->dsi", np.linalg.pinv((1.0 + 1e-6) * identity - shares), missed)
    scatter = np.einsum("dsi,dsj->dij", missed, missed)
    least = 1e-9 * np.sum(slopes**2) + TINY  # scatter, where columns explain all exactly
    solved = np.linalg.solve(scatter + least * identity, total[:, :, None])
    return np.asarray(np.sum(total * solved[..., 0], axis=1))


def explained(
    grams: np.ndarray, model: Sequence[int], groups: Sequence[Sequence[int]]
) -> list[float]:
    """Return how much of the target's square each group of columns explains beside a model.

    Parameters
    ----------
    grams : ndarray of shape (n_segments, n_columns + 1, n_columns + 1)
        Inner products of all columns, target last.
    model : sequence of int
        Columns of the model.
    groups : sequence of sequence of int
        Columns of each group.

    Returns
    -------
    list of float
    """
    sums = grams.sum(axis=0)
    total = _projected(sums[None], model, range(len(sums)))[0][0]
    slopes = total[:-1, -1]
    places = [list(group) for group in groups]
    return [float(slopes[k] @ solve(total[np.ix_(k, k)], slopes[k])) for k in places]


def _projected(
    grams: np.ndarray, model: Sequence[int], kept: Sequence[int]
) -> tuple[np.ndarray, np.ndarray]:
    """Return inner products with a model fitted to all segments projected out.

    Columns are scaled to unit size, or to zero if they are not new. The products are those of all
    columns with the kept ones, (n_segments, n_columns + 1, n_kept), and of each with itself,
    (n_segments, n_columns + 1).
    """
    base, total = np.asarray(model, dtype=int), grams.sum(axis=0)
    inner = np.broadcast_to(total[np.ix_(base, base)], (total.shape[1], len(base), len(base)))
    maps = solve(inner, total[base].T).T  # coefficients of each column on the model
    crossed, within = grams[:, base], grams[:, base][:, :, base] @ maps
    turned = np.sum(maps * (within - 2.0 * crossed), axis=1)
    squares = np.diagonal(grams, axis1=1, axis2=2) + turned
    square, total_square = squares.sum(axis=0), np.diagonal(total)
    new = square > MIN_NEW_SHARE * total_square
    new[base] = False
    unit = np.where(new, 1.0 / np.sqrt(np.where(new, square, 1.0)), 0.0)
    unit[-1] = 1.0
    keep = list(kept)
    halfway = grams[:, :, keep] - grams[:, :, base] @ maps[:, keep]
    free = halfway - maps.T @ halfway[:, base]
    return np.asarray(unit[:, None] * free * unit[keep]), np.asarray(unit**2 * squares)
