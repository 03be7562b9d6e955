r"""Take off states what their samples show of the steps of an input as if it were slow (aliasing).

A state that a held input drives directly runs in straight pieces, and its samples do not tell these
from the smooth curve that the model is about, which the mean of the input over a sampling time
drives. With the gain b of the input u, as it acts, the samples are off by

    \theta T^2 b du/dt,

where \theta is -1/12 if the steps come with the samples, has another size and sign if they come
between two of them, and vanishes where a lag rounds them off. So the share depends on what the
input goes through before it acts, of which nothing is known yet: the delay or the lag that leaves
least of the declared model is taken, for no more than this. Of a second integral next to nothing is
left, so that records of positions need no such care.

The share is the first term, in powers of frequency over sampling rate, of the response to the
sidebands of the steps; for a delay that is the second Bernoulli polynomial.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.optimize import minimize_scalar

from ...equations import Equations
from ...hidden_states.memory import DELAY, LAG, Memory
from ...signals import Record
from ...signals.zero_order_hold import acts_as, averaged, changed, rates_of
from ..given.design import Design
from .fit import derivative_fit_errors, refit

__all__ = ["share_of_steps", "without_aliases"]

LONGEST = 10.0  # sampling times by which an input may be late
DELAYS = np.arange(0.4, LONGEST, 0.4)  # sampling times, to begin with
LAGS = np.geomspace(0.1, LONGEST, 9)
CLEAR = 1.02  # a delay or a lag is taken only if the error without it is so many times larger
STEP = 1e-4  # of the range of an input, over which its gain is taken
SECOND = 0.05  # of the third derivative that the next term has, where steps come with the samples
ROUNDED = 0.1  # sampling times over a lag, below which a series is more exact


def without_aliases(
    design: Design, train: Sequence[Record], *others: Sequence[Record]
) -> list[list[Record]]:
    """Return records whose states are smooth, as their inputs are.

    Parameters
    ----------
    design : Design
        The declared model.
    train : sequence of Record
        Records that say how much the inputs do, and by how much they seem to be late.
    *others : sequence of Record
        More records.

    Returns
    -------
    list of list of Record
        All of them. Positions, and what no held input drives, stay as they are.
    """
    groups = [list(train), *map(list, others)]
    held = sorted({column for record in train if _is_aliased(record) for column in record.held})
    if not held:
        return groups
    meant = [[_with_means(record) for record in group] for group in groups]
    way = _Way(design, meant[0])
    for column in held:
        way = way.with_best(column)
    equations = design.equations(refit(design, way.acted(), "derivative"))
    through = {memory.column: memory for memory in way.memories}
    return [[_smooth(equations, record, through) for record in group] for group in meant]


def share_of_steps(memory: Memory | None, step: float) -> float:
    """Return the share of T^2 b du/dt that samples are behind, if an input goes through a memory.

    Parameters
    ----------
    memory : Memory, optional
        A delay or a lag; by default the steps come with the samples.
    step : float
        Sampling time, units of t.

    Returns
    -------
    float
    """
    if memory is None:
        return 1.0 / 12.0
    (value,) = memory.values
    if memory.kind == DELAY:
        part = (value / step) % 1.0
        return (1.0 - 6.0 * part * (1.0 - part)) / 12.0
    ratio = step / value
    if ratio < ROUNDED:
        return ratio**2 / 720.0
    return float(1.0 / 12.0 + ratio**-2 - 0.5 / (ratio * np.tanh(0.5 * ratio)))


@dataclass(frozen=True, eq=False)
class _Way:
    """What inputs seem to go through before they act, if the declared model lacks nothing else.

    The training records give held inputs as their means over a sampling time.
    """

    design: Design
    train: Sequence[Record]
    memories: tuple[Memory, ...] = ()

    def acted(self) -> list[Record]:
        """Return the records with what their samples show of the inputs."""
        return [self._shown(record) for record in self.train]

    def error(self) -> float:
        """Return what the declared model leaves of the derivatives, fitted."""
        acted = self.acted()
        return float(np.linalg.norm(derivative_fit_errors(self.design, acted, acted)))

    def with_best(self, column: int) -> _Way:
        """Return the same with what one more input seems to go through, if that is clear."""
        step = self.train[0].raw_dt
        kinds = ((DELAY, step * DELAYS), (LAG, step * LAGS))
        ways = [self._best(kind, column, values) for kind, values in kinds]
        best = min(ways, key=_Way.error)
        return best if self.error() > CLEAR * best.error() else self

    def _best(self, kind: str, column: int, values: np.ndarray) -> _Way:
        """Return the same with the delay or lag that leaves least."""

        def at(value: float) -> _Way:
            return replace(self, memories=(*self.memories, Memory(kind, column, (value,))))

        least = int(np.argmin([at(value).error() for value in values]))
        low = values[least - 1] if least else 0.0
        bounds = low, values[min(least + 1, len(values) - 1)]
        found = minimize_scalar(lambda value: at(value).error(), bounds=bounds, method="bounded")
        return at(float(found.x))

    def _shown(self, record: Record) -> Record:
        """Return a record with what its samples show of the inputs, given as their means."""
        through = {memory.column: memory for memory in self.memories}

        def shown(t: np.ndarray, u: np.ndarray) -> np.ndarray:
            acting = u.copy()
            for column in record.held:
                acting[:, column] = changed(
                    record, column, partial(_seen, through.get(column), t), u[:, column]
                )
            return acting

        return record.with_inputs(shown) if _is_aliased(record) else record


def _is_aliased(record: Record) -> bool:
    made = record.preparation
    return made is not None and made.order == 1 and bool(record.held)


def _with_means(record: Record) -> Record:
    """Return a record whose inputs are given as their means over a sampling time."""

    def meant(_: np.ndarray, u: np.ndarray) -> np.ndarray:
        acting = u.copy()
        for column, late in record.held.items():
            if column in record.through:  # from the steps, as these functions may end at zero
                mean, source = partial(averaged, late=late), record.recorded_u
                acting[:, column] = changed(record, column, mean, source[:, column])
            else:  # of the steps, from what samples show of them
                acting[:, column] = averaged(averaged(u[:, column], 0.0), 0.0)
        return acting

    return record.with_inputs(meant) if _is_aliased(record) else record


def _seen(memory: Memory | None, t: np.ndarray, u: np.ndarray) -> np.ndarray:
    """Return what samples of its integral show of the mean of an input behind a memory."""
    late, behind = _behind(memory, t, u)
    return late - rates_of(behind, 1)


def _behind(memory: Memory | None, t: np.ndarray, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the mean of an input behind a memory, and what samples of its integral are behind.

    Units of u, and of u times the sampling time.
    """
    late = u if memory is None else memory.response(t, u)
    share = share_of_steps(memory, float(t[-1] - t[0]) / (len(t) - 1))
    return late, share * (rates_of(late, 1) - SECOND * rates_of(late, 3))


def _smooth(equations: Equations, record: Record, through: dict[int, Memory]) -> Record:
    """Return a record without the straight pieces in its states."""
    if not _is_aliased(record):
        return record

    behind = sum(
        _gain(equations, record, column) * _bend(record, column, through.get(column))[:, None]
        for column in record.held
    )
    rate = CubicSpline(record.t, behind, axis=0)(record.t, 1)
    return replace(record, x=record.x + behind, x_dot=record.x_dot + rate)


def _bend(record: Record, column: int, memory: Memory | None) -> np.ndarray:
    """Return by how much samples of the integral of what acts of an input are behind it."""
    u = acts_as(record, column, record.raw_u[:, column])
    t = np.arange(len(u)) * record.raw_dt
    return record.raw_dt * record.lowpass(_behind(memory, t, u)[1])


def _gain(equations: Equations, record: Record, column: int) -> np.ndarray:
    """Return what acts of an input adds to the derivatives, (n_samples, n_states), per unit."""
    u = np.asarray(record.u)
    size = float(np.ptp(acts_as(record, column, u[:, column])))
    nudge = STEP * (size or 1.0)  # an input may rest in one record
    sides = []
    for way in (-nudge, nudge):
        nudged = u.copy()
        nudged[:, column] = changed(record, column, partial(np.add, way), u[:, column])
        sides.append(equations.evaluate(record.x, nudged, record.t))
    return np.nan_to_num((sides[1] - sides[0]) / (2.0 * nudge))  # where the model has no value
