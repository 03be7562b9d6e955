"""Which other effects could have left the same record? A confidence set, not a list of runners-up.

Two models that are not nested are compared by encompassing: a rival stands in the place of the
effect, all coefficients are refitted, and the effect is offered beside it once more. If the rival
were the cause, the effect would gain no more beside it than chance gives to the best of all
candidates. Chance is measured by the wild cluster bootstrap: what both together leave is multiplied
by a random sign on each piece of the record, so that the color of the noise and its changes from
piece to piece stay, and each time the largest gain of all candidates is noted. (What the rival
alone leaves would hold the effect itself, and with it a few loud pieces could pass for chance.)

A rival that is not refuted at the significance level is an alternative. The cause, if it is among
the candidates, is lost from the set with no larger chance than that.

References
----------
Mizon and Richard, Econometrica 54 (1986), DOI 10.2307/1911313: encompassing.
Davidson and MacKinnon, Econometrica 49 (1981), DOI 10.2307/1911522: the J test.
Cameron, Gelbach and Miller, Rev. Econ. Stat. 90 (2008), DOI 10.1162/rest.90.3.414: the bootstrap.
Romano and Wolf, Econometrica 73 (2005), DOI 10.1111/j.1468-0262.2005.00615.x: the largest gain.

======  ==============================================  ======================================
symbol  shape                                           meaning
======  ==============================================  ======================================
grams   (n_segments, n_columns + 1, n_columns + 1)      whitened inner products, target last
slopes  (n_segments, n_columns)                         what each column still explains
sizes   (n_columns,)                                    squares of the columns, model's part out
======  ==============================================  ======================================
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .linear import solve

__all__ = ["Left", "chance", "left_by"]

N_SIGNS = 999


@dataclass(frozen=True, eq=False)
class Left:
    """What columns could still explain, segment by segment, beside a model."""

    slopes: np.ndarray
    sizes: np.ndarray

    def gains(self, signs: np.ndarray) -> np.ndarray:
        """Return the square that each column explains under signs, (n_draws, n_columns)."""
        return (signs @ self.slopes) ** 2 / self.sizes


def left_by(grams: np.ndarray, model: Sequence[int], beside: Sequence[int] = ()) -> Left:
    """Return what all columns could explain of what a model leaves.

    Parameters
    ----------
    grams : ndarray of shape (n_segments, n_columns + 1, n_columns + 1)
        Inner products of all columns, target last.
    model : sequence of int
        Columns of the model.
    beside : sequence of int
        Columns that the target, but not the other columns, are freed of as well.

    Returns
    -------
    Left
        The columns of the model themselves explain nothing more.
    """
    base, total = np.asarray(model, dtype=int), grams.sum(axis=0)
    inner = np.broadcast_to(total[np.ix_(base, base)], (total.shape[1], len(base), len(base)))
    maps = solve(inner, total[base].T).T  # of each column on the model
    whole = np.asarray((*model, *beside), dtype=int)
    coef = solve(total[np.ix_(whole, whole)], total[whole, -1])
    rest = grams[:, :, -1] - grams[:, :, whole] @ coef
    slopes = rest - rest[:, base] @ maps
    sizes = np.diagonal(total) - np.sum(total[base] * maps, axis=0)
    new = sizes > 1e-6 * np.diagonal(total)
    new[base] = False
    slopes = np.where(new, slopes, 0.0)[:, :-1]
    return Left(slopes, np.where(new, sizes, 1.0)[:-1])


def chance(
    grams: np.ndarray, model: Sequence[int], columns: Sequence[int], rng: np.random.Generator
) -> float:
    """Return the chance of gains as large as those of some columns, if the model were the cause.

    Parameters
    ----------
    grams : ndarray of shape (n_segments, n_columns + 1, n_columns + 1)
        Inner products of all columns, target last.
    model : sequence of int
        Columns of the rival's model.
    columns : sequence of int
        Columns of the effect; the one that gains most counts.
    rng : numpy.random.Generator
        Draws the signs.

    Returns
    -------
    float
    """
    n_segments = len(grams)
    observed = left_by(grams, model).gains(np.ones((1, n_segments)))[0, list(columns)].max()
    signs = rng.choice([-1.0, 1.0], size=(N_SIGNS, n_segments))
    signs *= np.sqrt(n_segments / max(n_segments - 1, 1))  # the fit took a part of the noise
    largest = left_by(grams, model, columns).gains(signs).max(axis=1)
    return float((1 + np.sum(largest >= observed)) / (1 + N_SIGNS))
