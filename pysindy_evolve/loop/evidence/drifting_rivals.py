"""The test of a rival on short trajectories: whether it could have left the same record.

Twins are made of the model with the rival in place of the effect. In them the rival is the cause,
but another candidate may do better by chance. If in more than a few twins the best candidate leads
the rival by as much as in the record, the rival is an alternative.

References
----------
Cox, J. R. Stat. Soc. B 24 (1962), DOI 10.1111/j.2517-6161.1962.tb00468.x: models not nested.
Williams, Biometrics 26 (1970), DOI 10.2307/2529002: the same by simulation.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...signals import Record
from ..effects.candidate import Candidate
from ..fitting.trajectory import Trajectories
from ..given.design import Column, Design
from ..twins.chance import draws_for, p_value_of
from ..twins.drifting import DriftingTwins
from .scoring import columns_of

N_TWINS = 99
MIN_TWINS = 19  # twins after which a rival is refuted if none comes near ...
MIN_LEAD_RATIO = 2.0  # ... that is, within this factor of its lead
# Lead in log error that needs no twins: the error is twelve times as large.
LEAD_WITHOUT_TWINS_LOG = 5.0


def twin_chance(
    rival: Candidate,
    design: Design,
    options: Sequence[Candidate],
    records: Sequence[Record],
    level: float,
    rng: np.random.Generator,
) -> float:
    """Return the chance that the best option leads a rival by so much, if the rival is the cause.

    Parameters
    ----------
    rival : Candidate
        The supposed cause.
    design : Design
        The model without it.
    options : sequence of Candidate
        All that may be the cause, the rival among them; the first is the effect itself. A rival
        whose run goes to infinity, where that of the effect does not, is no cause.
    records : sequence of Record
        Training records.
    level : float
        No more twins are made once it is clear that the chance is larger.
    rng : numpy.random.Generator
        Draws the twins.

    Returns
    -------
    float
    """
    observed, n_twins = _lead(rival, design, options, records), draws_for(level, N_TWINS)
    if observed > LEAD_WITHOUT_TWINS_LOG:
        return 1.0 / (1 + n_twins)
    maker = _twins_of(rival, design, records)
    if not maker.is_finite and _twins_of(options[0], design, records).is_finite:
        return 1.0 / (1 + n_twins)
    leads: list[float] = []
    for child in rng.spawn(n_twins):
        leads.append(_lead(rival, design, options, maker.make(child)))
        stands = np.sum(np.array(leads) >= observed) > level * (n_twins + 1)
        if stands:
            break
        if len(leads) >= MIN_TWINS and MIN_LEAD_RATIO * max(leads) < observed:
            return 1.0 / (1 + n_twins)
    return p_value_of(observed, leads)


def _twins_of(cause: Candidate, design: Design, records: Sequence[Record]) -> DriftingTwins:
    return DriftingTwins.of(design.adding(columns_of(cause, design)), records)


def _lead(
    rival: Candidate, design: Design, options: Sequence[Candidate], records: Sequence[Record]
) -> float:
    """Return the log error by which the best option leads a rival."""
    leads = leads_over(options, design, records)
    return float(leads[next(k for k, option in enumerate(options) if option is rival)])


def leads_over(
    options: Sequence[Candidate], design: Design, records: Sequence[Record]
) -> np.ndarray:
    """Return the log errors by which the best of several options leads each of them.

    Parameters
    ----------
    options : sequence of Candidate
        What may be the cause.
    design : Design
        The model without any of them.
    records : sequence of Record
        Training records.

    Returns
    -------
    ndarray of shape (n_options,)
    """
    columns: list[Column] = list(design.columns)
    base = tuple(range(len(columns)))
    models: list[tuple[int, ...]] = []
    for option in options:
        added = columns_of(option, design)
        models.append((*base, *range(len(columns), len(columns) + len(added))))
        columns += added
    track = Trajectories(records, design, columns)
    sizes = np.array([len(model) for model in models])
    errors = np.empty(len(models))
    for size in np.unique(sizes):
        same_size = np.flatnonzero(sizes == size)
        errors[same_size] = track.errors(np.array([models[k] for k in same_size]))[:, 0]
    return np.asarray(np.log(errors / errors.min()))
