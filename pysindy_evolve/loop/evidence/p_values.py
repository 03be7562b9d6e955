"""P-values: how often twins of the models in which nothing may be missing do as well.

Sensor noise in a small difference of large motions, such as the twist of a shaft, makes least
squares underestimate its stiffness, and the lacking part looks like an effect. In twins of such a
fit the twist is larger, and the noise matters less. So where twins show that noise shifts the
coefficients, an effect must pass once more: among twins of a model whose fit, shifted by noise, is
that of the record. A fit to free runs, which contain no noise, comes near this model.

References
----------
Gouriéroux, Monfort and Renault, J. Appl. Econometrics 8 (1993), DOI 10.1002/jae.3950080507:
indirect inference.
"""

from __future__ import annotations

from functools import partial

import numpy as np

from ...equations import Equations
from ..fitting.linear import solve_gram, square_of
from ..fitting.residual import derivative_grams
from ..fitting.shooting import fit_to_runs
from ..fitting.unfolding import records_with_hidden_states, square_left, with_hidden_states
from ..given.design import Design
from ..given.rules import Rules
from ..given.segments import Segments
from ..twins.chance import Statistic, chance_on_twins
from ..twins.drifting import DriftingTwins
from ..twins.twins import TwinMaker

N_TWINS = 8  # twins that show by how much noise shifts the coefficients
N_STEPS = 3  # corrections of the fit to free runs, each of which halves its error
SHIFTED = 0.01  # share of a fit's residual square that a notable shift of coefficients changes


def chance_of(
    observed: float,
    statistic: Statistic,
    design: Design,
    equations: Equations,
    part: Segments,
    rules: Rules,
    rng: np.random.Generator,
) -> tuple[float, np.ndarray]:
    """Return the p-value of a statistic, and the statistic of the twins that it comes from.

    Parameters
    ----------
    observed : float
        The statistic of the records.
    statistic : callable
        Maps the pieces of records to a number.
    design : Design
        The model in which nothing is missing.
    equations : Equations
        Its fit to the records.
    part : Segments
        Pieces of the training records.
    rules : Rules
        Significance and twins.
    rng : numpy.random.Generator
        Draws the twins.

    Returns
    -------
    p_value : float
    twins : ndarray of shape (n_twins,)
    """
    maker = (
        DriftingTwins.of(design, part.records)
        if part.by_trajectory
        else TwinMaker.of(equations, part.records)
    )
    chance = chance_on_twins(maker, part, statistic, observed, rules, rng)
    if chance[0] > rules.level or isinstance(maker, DriftingTwins):
        return chance
    unshifted = without_noise_shift(maker, design, part, rng.spawn(1)[0])
    if unshifted is None:
        return chance
    of_unshifted = TwinMaker.of(unshifted, part.records)
    other = chance_on_twins(of_unshifted, part, statistic, observed, rules, rng)
    return max(chance, other, key=lambda pair: pair[0])


def without_noise_shift(
    maker: TwinMaker, design: Design, part: Segments, rng: np.random.Generator
) -> Equations | None:
    """Return the model whose twins have the fit of the record, where noise shifts that fit.

    Parameters
    ----------
    maker : TwinMaker
        Makes twins of the fit to the derivative.
    design : Design
        The model.
    part : Segments
        Pieces of the records.
    rng : numpy.random.Generator
        Draws the twins that show a shift.

    Returns
    -------
    Equations or None
        None if noise shifts nothing notable, or if free runs give no start.
    """
    if not design.columns or any(path is None for path in maker.simulated):
        return None
    gram = _gram(design, part)
    coef = solve_gram(gram)
    shift = np.append(_shift(maker, coef, design, part, rng), 0.0)
    if shift @ gram @ shift < SHIFTED * square_of(gram, coef):
        return None
    records = maker.records
    loss = partial(square_left, design, records)
    found = fit_to_runs(
        with_hidden_states(design), coef, records_with_hidden_states(design, records), loss
    )
    if found is None:
        return None
    for _ in range(N_STEPS):
        followed = TwinMaker.of(design.equations(found), records)
        if any(path is None for path in followed.simulated):
            return None
        found = found - _shift(followed, coef, design, part, rng)
    return design.equations(found)


def _shift(
    maker: TwinMaker, coef: np.ndarray, design: Design, part: Segments, rng: np.random.Generator
) -> np.ndarray:
    """Return the mean difference of the coefficients fitted to twins from given ones."""
    fits = [solve_gram(_gram(design, part.of(maker.make(c)))) for c in rng.spawn(N_TWINS)]
    return np.asarray(np.mean(fits, axis=0) - coef)


def _gram(design: Design, part: Segments) -> np.ndarray:
    return np.asarray(derivative_grams(part, design, design.columns).sum(axis=0))
