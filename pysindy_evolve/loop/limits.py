"""Limits that a record shows: a state that stays at its highest or lowest value for a while."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import maximum_filter1d

from ..equations import Equations
from ..operators import BUILTIN
from ..signals import Record
from ..signals.noise import DWELL
from ..terms import Sum, add, call, constant, mul, sub, variable
from .design import Design
from .paths import follow
from .segments import Segments

__all__ = ["LIMITED", "Limit", "limited", "limits_of", "off_limits", "plateaus"]

LIMITED = "saturation"  # its name
LEAST = 3  # samples at the limit, one after the other
NEAR = 0.01  # standard deviations from a limit at which a state counts as being there


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
        beyond = sub(variable(self.state), constant(self.value))
        size = call(BUILTIN["abs"], beyond)
        both = add(beyond, size) if self.upper else sub(beyond, size)
        return mul(constant(-0.5 * self.rate), both)


def limited(design: Design, limits: Sequence[Limit]) -> Design:
    """Return a design in which states do not pass limits."""
    fixed = list(design.fixed)
    for limit in limits:
        fixed[limit.state] = add(fixed[limit.state], limit.term)
    return replace(design, fixed=tuple(fixed))


def limits_of(design: Design, records: Sequence[Record]) -> list[Limit]:
    """Return the limits that raw records of first-order states show.

    A coarse sensor repeats its readings wherever the state is slow, and shows none.

    Parameters
    ----------
    design : Design
        The model: a state whose equation is open may be limited.
    records : sequence of Record
        Training records; without raw data nothing is seen.

    Returns
    -------
    list of Limit
    """
    made = [record.preparation for record in records]
    if any(one is None or one.order != 1 for one in made):
        return []
    found = []
    for state in design.open_states:
        columns = [one.y[:, state] for one in made if one is not None]
        for upper in (True, False):
            extreme = max(c.max() for c in columns) if upper else min(c.min() for c in columns)
            if _plateau(columns, upper) >= LEAST and not _is_coarse(columns, extreme):
                found.append(Limit(state, float(extreme), 1.0 / records[0].dt, upper))
    return found


def off_limits(part: Segments, limits: Sequence[Limit]) -> Segments:
    """Return pieces in which rows at a limit carry no weight: there the sensor says nothing."""
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
    found = [path.y[:, limit.state] for path in paths if path is not None]
    raw = [one.y[:, limit.state] for one in made]
    observed = _plateau(raw, limit.upper)
    if len(found) < len(raw):
        return observed, np.full(n_twins, np.inf)
    noise = [float(one.noise[limit.state]) for one in made]
    lengths = []
    for _ in range(n_twins):
        twins = [y + s * rng.standard_normal(len(y)) for y, s in zip(found, noise, strict=True)]
        lengths.append(_plateau(twins, limit.upper))
    return observed, np.array(lengths, dtype=float)


def _is_coarse(columns: Sequence[np.ndarray], extreme: float) -> bool:
    """Tell whether readings repeat away from an extreme as well: it then is no more than a rest."""
    repeats = [np.diff(c[c != extreme]) == 0.0 for c in columns]
    every = np.concatenate(repeats)
    return len(every) == 0 or bool(every.mean() >= DWELL)


def _plateau(columns: Sequence[np.ndarray], upper: bool) -> int:
    """Return for how many samples in a row columns stay at the extreme of all of them."""
    extreme = max(c.max() for c in columns) if upper else min(c.min() for c in columns)
    return max(_longest(column == extreme) for column in columns)


def _longest(there: np.ndarray) -> int:
    """Return the length of the longest run of True."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], there, [False]]).astype(int)))
    return int(np.max(edges[1::2] - edges[::2], initial=0))
