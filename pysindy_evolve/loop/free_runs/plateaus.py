"""How long a reading stays at its highest or lowest value, in records and in twins."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...equations import Equations
from ...signals import Record
from ...signals.clipping import longest
from ..given.limits import Limit
from ..given.rules import Rules
from ..twins.chance import draws_for, p_value_of
from ..twins.paths import follow

N_TWINS = 999  # cheap: all share one run, and differ in the noise


def limits_beyond_chance(
    limits: Sequence[Limit],
    equations: Equations,
    records: Sequence[Record],
    rules: Rules,
    rng: np.random.Generator,
) -> list[tuple[Limit, int, float, np.ndarray]]:
    """Return the limits at which records stay longer than twins without limits do, with evidence.

    Parameters
    ----------
    limits : sequence of Limit
        What the records show.
    equations : Equations
        The model in which nothing is limited.
    records : sequence of Record
        Training records, inputs as they act.
    rules : Rules
        When a limit counts.
    rng : numpy.random.Generator
        Draws the noise of the twins.

    Returns
    -------
    list of (Limit, int, float, ndarray of shape (n_twins,))
        Each with the longest plateau in samples, its p-value, and the plateaus of the twins.
    """
    found, n_twins = [], draws_for(rules.level_of_runs, N_TWINS)
    for limit in limits:
        length, lengths = plateaus(limit, equations, records, n_twins, rng)
        p_value = p_value_of(length, lengths)
        if p_value <= rules.level_of_runs:
            found.append((limit, length, p_value, lengths))
    return found


def plateaus(
    limit: Limit,
    equations: Equations,
    records: Sequence[Record],
    n_twins: int,
    rng: np.random.Generator,
) -> tuple[int, np.ndarray]:
    """Return how long the records, and twins without the limit, stay at their extreme value.

    Parameters
    ----------
    limit : Limit
        What the records show.
    equations : Equations
        The model in which nothing is limited.
    records : sequence of Record
        Training records, prepared from raw data.
    n_twins : int
        Number of twins: paths of the model along the records, plus sensor noise.
    rng : numpy.random.Generator
        Draws the noise.

    Returns
    -------
    observed : int
        Longest plateau, in samples.
    in_twins : ndarray of shape (n_twins,)
        The same of each twin; infinite if the model cannot follow a record.
    """
    paths = [follow(equations, record) for record in records]
    made = [record.preparation for record in records if record.preparation is not None]
    column = limit.state // made[0].order
    clean = [path.y[:, column] for path in paths if path is not None]
    raw = [one.y[:, column] for one in made]
    observed = _plateau(raw, limit.upper)
    if len(clean) < len(raw):
        return observed, np.full(n_twins, np.inf)
    step = _resolution(raw)
    # The variance of rounding is subtracted, since the twins are rounded below.
    noise = [np.sqrt(max(one.noise[column] ** 2 - step**2 / 12.0, 0.0)) for one in made]
    lengths = []
    for _ in range(n_twins):
        twins = [y + s * rng.standard_normal(len(y)) for y, s in zip(clean, noise, strict=True)]
        lengths.append(_plateau([step * np.round(y / step) for y in twins], limit.upper))
    return observed, np.array(lengths, dtype=float)


def _resolution(columns: Sequence[np.ndarray]) -> float:
    """Return the least step between readings; a coarse sensor repeats readings by itself."""
    return float(np.diff(np.unique(np.concatenate(columns))).min())


def _plateau(columns: Sequence[np.ndarray], upper: bool) -> int:
    """Return the most samples in a row for which a column stays at the extreme of all columns."""
    extreme = max(c.max() for c in columns) if upper else min(c.min() for c in columns)
    return max(longest(column == extreme) for column in columns)
