"""Limits that a record shows: a reading that stays at its highest or lowest value for a while."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import maximum_filter1d

from ...equations import Equations
from ...operators import BUILTIN
from ...signals import Record
from ...signals.clipping import longest
from ...terms import Sum, add, call, constant, mul, sub, variable
from ..given.design import Design
from ..given.rules import Rules
from ..given.segments import Segments
from ..given.sensor import ends_of
from ..twins.chance import p_value_of
from ..twins.paths import follow

__all__ = ["LIMITED", "Limit", "limited", "limits_of", "off_limits", "plateaus", "tested"]

LIMITED = "saturation"  # its name
NEAR = 0.01  # standard deviations from a limit at which a state counts as being there
N_TWINS = 999  # which cost next to nothing: one run, and noise


@dataclass(frozen=True)
class Limit:
    """A value that a state does not pass.

    Attributes
    ----------
    state : int
        Which state.
    value : float
        Where it ends, units of the state.
    rate : float
        How fast it comes back from beyond, 1 per unit of t.
    upper : bool
        Whether it is the highest value, or the lowest.
    """

    state: int
    value: float
    rate: float
    upper: bool

    @property
    def term(self) -> Sum:
        """What it adds to the rate of the state: -rate * max(x - value, 0), or the mirror image."""
        return mul(constant(-self.rate), self._excess)

    @property
    def reading(self) -> Sum:
        """What a sensor with this limit shows: min(x, value), or max."""
        return sub(variable(self.state), self._excess)

    @property
    def _excess(self) -> Sum:
        beyond = sub(variable(self.state), constant(self.value))
        size = call(BUILTIN["abs"], beyond)
        both = add(beyond, size) if self.upper else sub(beyond, size)
        return mul(constant(0.5), both)


def limited(design: Design, limits: Sequence[Limit]) -> Design:
    """Return a design in which states do not pass limits."""
    fixed = list(design.fixed)
    for limit in limits:
        fixed[limit.state] = add(fixed[limit.state], limit.term)
    return replace(design, fixed=tuple(fixed))


def limits_of(records: Sequence[Record]) -> list[Limit]:
    """Return the limits of readings that raw records show, whatever they are limits of.

    Parameters
    ----------
    records : sequence of Record
        Training records; without raw data nothing is seen.

    Returns
    -------
    list of Limit
    """
    ends = ends_of(records)
    if ends is None:
        return []
    rate = 1.0 / records[0].dt
    found = (
        Limit(state, float(ends[int(upper), state]), rate, upper)
        for state in range(ends.shape[1])
        for upper in (True, False)
    )
    return [limit for limit in found if np.isfinite(limit.value)]


def tested(
    limits: Sequence[Limit],
    equations: Equations,
    records: Sequence[Record],
    rules: Rules,
    rng: np.random.Generator,
) -> list[tuple[Limit, int, float, np.ndarray]]:
    """Return the limits at which records stay longer than twins without them, with the evidence.

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
        With samples in a row, their chance, and the same samples in the twins.
    """
    found = []
    for limit in limits:
        length, lengths = plateaus(limit, equations, records, N_TWINS, rng)
        p_value = p_value_of(length, lengths)
        if p_value <= rules.level_of_runs:
            found.append((limit, length, p_value, lengths))
    return found


def off_limits(part: Segments, limits: Sequence[Limit]) -> Segments:
    """Return pieces in which rows at a limit carry no weight: there no equation holds."""
    weight = part.weight.copy()
    for limit in limits:
        x, near = part.z[:, :, limit.state], NEAR * part.state_scale[limit.state]
        there = x >= limit.value - near if limit.upper else x <= limit.value + near
        # The preparation carries what happens there as far as its windows reach.
        wide = maximum_filter1d(there.astype(int), 2 * part.windows.width + 1, axis=1)
        weight[:, :, limit.state] *= wide == 0
    return replace(part, weight=weight)


def plateaus(
    limit: Limit,
    equations: Equations,
    records: Sequence[Record],
    n_twins: int,
    rng: np.random.Generator,
) -> tuple[int, np.ndarray]:
    """Return for how many samples the records, and twins without the limit, stay at an extreme.

    Parameters
    ----------
    limit : Limit
        What the records show.
    equations : Equations
        The model in which nothing is limited.
    records : sequence of Record
        Training records, prepared from raw data.
    n_twins : int
        Paths of the model beside the records, with the noise of the sensor.
    rng : numpy.random.Generator
        Draws the noise.

    Returns
    -------
    observed : int
        Samples in a row.
    in_twins : ndarray of shape (n_twins,)
        The same; infinite where the model cannot follow a record.
    """
    paths = [follow(equations, record) for record in records]
    made = [record.preparation for record in records if record.preparation is not None]
    column = limit.state // made[0].order
    found = [path.y[:, column] for path in paths if path is not None]
    raw = [one.y[:, column] for one in made]
    observed = _plateau(raw, limit.upper)
    if len(found) < len(raw):
        return observed, np.full(n_twins, np.inf)
    noise = [float(one.noise[column]) for one in made]
    lengths = []
    for _ in range(n_twins):
        twins = [y + s * rng.standard_normal(len(y)) for y, s in zip(found, noise, strict=True)]
        lengths.append(_plateau(twins, limit.upper))
    return observed, np.array(lengths, dtype=float)


def _plateau(columns: Sequence[np.ndarray], upper: bool) -> int:
    """Return for how many samples in a row columns stay at the extreme of all of them."""
    extreme = max(c.max() for c in columns) if upper else min(c.min() for c in columns)
    return max(longest(column == extreme) for column in columns)
