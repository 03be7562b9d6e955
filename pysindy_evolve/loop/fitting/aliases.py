r"""Remove the aliases of the steps of an input from sampled states.

A state that a held input drives directly runs in straight pieces. The model describes a smooth
curve instead, which the mean of the input over a sampling time T drives. With the gain b of the
input u, as it acts, samples of the pieces differ from the smooth curve by

    \theta T^2 b du/dt,

where \theta is -1/12 if the steps come with the samples, has another size and sign if they come
between two samples, and vanishes if a lag rounds them off. So it depends on the delay or lag of the
input, which is not known yet. The delay or lag with the least residual of the declared model is
taken, for this purpose only. In a second integral the aliases are negligible, so records of
positions are not corrected.

The share \theta is the first term, in powers of frequency over sampling rate, of the response to
the sidebands of the steps; for a delay that is the second Bernoulli polynomial.
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
from ...signals.sampling import mean_step
from ...signals.zero_order_hold import acts_as, apply_to_effective_input, averaged, rates_of
from ..given.design import Design
from .fit import derivative_fit_errors, refit

MAX_LENGTH_IN_SAMPLES = 10.0  # longest delay or lag, in sampling times
DELAYS = np.arange(0.4, MAX_LENGTH_IN_SAMPLES, 0.4)  # grid of delays, in sampling times
LAGS = np.geomspace(0.1, MAX_LENGTH_IN_SAMPLES, 9)  # grid of lags, in sampling times
# A delay or lag is taken only if the error without it is larger by this factor.
MIN_ERROR_RATIO = 1.02
INPUT_STEP_SHARE = 1e-4  # finite difference for the gain of an input, relative to its range
# Factor of the third derivative in the next term, for steps at the samples.
THIRD_DERIVATIVE_FACTOR = 0.05
MAX_SERIES_RATIO = 0.1  # sampling time over lag below which the series is more accurate


def without_aliases(
    design: Design, train: Sequence[Record], *others: Sequence[Record]
) -> list[list[Record]]:
    """Return records whose states are free of the aliases of input steps.

    Parameters
    ----------
    design : Design
        The declared model.
    train : sequence of Record
        Records from which the gains and apparent delays of the inputs are estimated.
    *others : sequence of Record
        More records.

    Returns
    -------
    list of list of Record
        All of them. Positions, and states that no held input drives, are unchanged.
    """
    groups = [list(train), *map(list, others)]
    held = sorted({column for record in train if _is_aliased(record) for column in record.held})
    if not held:
        return groups
    with_means = [[_with_means(record) for record in group] for group in groups]
    way = _Way(design, with_means[0])
    for column in held:
        way = way.with_best(column)
    equations = design.equations(refit(design, way.acted(), "derivative"))
    through = {memory.column: memory for memory in way.memories}
    return [[_smooth(equations, record, through) for record in group] for group in with_means]


def share_of_steps(memory: Memory | None, step: float) -> float:
    """Return the share -theta of T^2 b du/dt, by which samples fall short, behind a memory.

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
    if ratio < MAX_SERIES_RATIO:
        return ratio**2 / 720.0
    return float(1.0 / 12.0 + ratio**-2 - 0.5 / (ratio * np.tanh(0.5 * ratio)))


@dataclass(frozen=True, eq=False)
class _Way:
    """Delays and lags that inputs seem to have, if the declared model lacks nothing else.

    In `train`, held inputs are given as their means over a sampling time.
    """

    design: Design
    train: Sequence[Record]
    memories: tuple[Memory, ...] = ()

    def acted(self) -> list[Record]:
        """Return the records with inputs as the samples of the states show them."""
        return [self._shown(record) for record in self.train]

    def error(self) -> float:
        """Return the error of the derivatives of the declared model, fitted."""
        acted = self.acted()
        return float(np.linalg.norm(derivative_fit_errors(self.design, acted, acted)))

    def with_best(self, column: int) -> _Way:
        """Return the same with the best delay or lag of one more input, if that clearly helps."""
        step = self.train[0].raw_dt
        kinds = ((DELAY, step * DELAYS), (LAG, step * LAGS))
        options = [self._best(kind, column, values) for kind, values in kinds]
        best = min(options, key=_Way.error)
        return best if self.error() > MIN_ERROR_RATIO * best.error() else self

    def _best(self, kind: str, column: int, values: np.ndarray) -> _Way:
        """Return the same with the delay or lag of least error."""

        def at(value: float) -> _Way:
            return replace(self, memories=(*self.memories, Memory(kind, column, (value,))))

        least = int(np.argmin([at(value).error() for value in values]))
        low = values[least - 1] if least else 0.0
        bounds = low, values[min(least + 1, len(values) - 1)]
        found = minimize_scalar(lambda value: at(value).error(), bounds=bounds, method="bounded")
        return at(float(found.x))

    def _shown(self, record: Record) -> Record:
        """Return a record, given mean inputs, with inputs as samples of the states show them."""
        through = {memory.column: memory for memory in self.memories}

        def shown(t: np.ndarray, u: np.ndarray) -> np.ndarray:
            acting = u.copy()
            for column in record.held:
                acting[:, column] = apply_to_effective_input(
                    record, column, partial(_sampled, through.get(column), t), u[:, column]
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
            if column in record.through:  # from the steps, as a root may end at zero
                mean, source = partial(averaged, late=late), record.recorded_u
                acting[:, column] = apply_to_effective_input(
                    record, column, mean, source[:, column]
                )
            else:  # from what samples of an integral show of the steps
                acting[:, column] = averaged(averaged(u[:, column], 0.0), 0.0)
        return acting

    return record.with_inputs(meant) if _is_aliased(record) else record


def _sampled(memory: Memory | None, t: np.ndarray, u: np.ndarray) -> np.ndarray:
    """Return the mean of an input after a memory, as samples of its integral show it."""
    response, shortfall = _response(memory, t, u)
    return response - rates_of(shortfall, 1)


def _response(memory: Memory | None, t: np.ndarray, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the mean of an input after a memory, and the shortfall of samples of its integral.

    Units of u, and of u times the sampling time.
    """
    response = u if memory is None else memory.response(t, u)
    share = share_of_steps(memory, mean_step(t))
    return response, share * (
        rates_of(response, 1) - THIRD_DERIVATIVE_FACTOR * rates_of(response, 3)
    )


def _smooth(equations: Equations, record: Record, through: dict[int, Memory]) -> Record:
    """Return a record with its states moved from the straight pieces to the smooth curve."""
    if not _is_aliased(record):
        return record

    shortfall = sum(
        _gain(equations, record, column) * _shortfall(record, column, through.get(column))[:, None]
        for column in record.held
    )
    rate = CubicSpline(record.t, shortfall, axis=0)(record.t, 1)
    return replace(record, x=record.x + shortfall, x_dot=record.x_dot + rate)


def _shortfall(record: Record, column: int, memory: Memory | None) -> np.ndarray:
    """Return by how much samples of the integral of an input, as it acts, fall short."""
    u = acts_as(record, column, record.raw_u[:, column])
    t = np.arange(len(u)) * record.raw_dt
    return record.raw_dt * record.lowpass(_response(memory, t, u)[1])


def _gain(equations: Equations, record: Record, column: int) -> np.ndarray:
    """Return the slope of the derivatives in an input as it acts, (n_samples, n_states)."""
    u = np.asarray(record.u)
    size = float(np.ptp(acts_as(record, column, u[:, column])))
    nudge = INPUT_STEP_SHARE * (size or 1.0)  # an input may rest in one record
    sides = []
    for step in (-nudge, nudge):
        nudged = u.copy()
        nudged[:, column] = apply_to_effective_input(
            record, column, partial(np.add, step), u[:, column]
        )
        sides.append(equations.evaluate(record.x, nudged, record.t))
    return np.nan_to_num((sides[1] - sides[0]) / (2.0 * nudge))  # zero where the model has no value
