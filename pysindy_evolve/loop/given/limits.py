"""Limits that readings show: of a state that stops there, or of its sensor."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import maximum_filter1d

from ...operators import BUILTIN
from ...signals import Record
from ...terms import Sum, add, call, constant, mul, sub, variable
from .design import Design
from .segments import Segments
from .sensor import ends_of

LIMITED = "saturation"  # name of the effect
# Distance, in standard deviations, at which a state counts as being at a limit.
MAX_DISTANCE_FROM_LIMIT = 0.01


@dataclass(frozen=True)
class Limit:
    """A value that a state does not pass.

    Attributes
    ----------
    state : int
        Which state.
    value : float
        The value, units of the state.
    rate : float
        How fast the state comes back from beyond it, 1 per unit of t.
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
        doubled = add(beyond, size) if self.upper else sub(beyond, size)
        return mul(constant(0.5), doubled)


def limited(design: Design, limits: Sequence[Limit]) -> Design:
    """Return a design in which states do not pass limits."""
    fixed = list(design.fixed)
    for limit in limits:
        fixed[limit.state] = add(fixed[limit.state], limit.term)
    return replace(design, fixed=tuple(fixed))


def limits_of(records: Sequence[Record]) -> list[Limit]:
    """Return the limits of readings that raw records show, of states and of sensors alike.

    Parameters
    ----------
    records : sequence of Record
        Training records; without raw data there are none.

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


def off_limits(part: Segments, limits: Sequence[Limit]) -> Segments:
    """Return pieces in which rows at a limit carry no weight: there no equation holds."""
    weight = part.weight.copy()
    for limit in limits:
        x, near = part.z[:, :, limit.state], MAX_DISTANCE_FROM_LIMIT * part.state_scale[limit.state]
        at_limit = x >= limit.value - near if limit.upper else x <= limit.value + near
        # The windows spread what happens at a limit as far as they reach.
        affected = maximum_filter1d(at_limit.astype(int), 2 * part.windows.width + 1, axis=1)
        weight[:, :, limit.state] *= affected == 0
    return replace(part, weight=weight)
