"""Refine coefficients by the true simulation: multiple shooting.

The fit of the simulation error in `fit` is linear, about the measured states. Here the model runs
by itself over stretches of the record, as long as it stays close, and Gauss-Newton steps change its
coefficients, and the states in which the stretches begin, until it meets what was measured. Noise
of the sensor enters neither the states nor their derivatives of such a run, and biases nothing.

References
----------
Bock, Recent advances in parameter identification techniques for O.D.E., in: Numerical Treatment of
Inverse Problems in Differential and Integral Equations (1983), 95-121: multiple shooting.
Leine, Nijmeijer, Dynamics and Bifurcations of Non-Smooth Mechanical Systems (2004), chapter 7: what
a switch does to a deviation, the saltation matrix.

======  ==============================================  ======================================
symbol  shape                                           meaning
======  ==============================================  ======================================
starts  (n_stretches, n_states)                         states in which the runs begin
x       (n_stretches, n, n_states)                      states of the runs
miss    (n_stretches, n, n_states)                      measured states less x
======  ==============================================  ======================================
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..signals import Record
from .design import Design
from .fit import Fit, derivative_square
from .residual import MAX_GROWTH, forces, jacobian, respond
from .runs import free_run, stretch_misses
from .segments import Segments, segments

__all__ = ["shot"]

N_STRETCHES = (4, 8, 16, 32)  # of the training data; the fewest that the model can follow
FAITHFUL = 0.5  # standard deviations by which a run may miss
JUDGED = 16  # stretches of each record, from measured states, by which a change is judged
MAX_ROWS = 40_000  # a longer record costs too much, and its linear fit scatters little
ROWS = 2000  # of the runs that a step looks at
MAX_STEPS = 6  # of Gauss-Newton; two or three are the rule
SHORTENED = (1.0, 0.5, 0.25)  # a step that makes the error larger is tried again
SETTLED = 1e-3  # relative gain of a step after which no other one is taken
LARGEST_JUMP = 10.0  # of a deviation at a switch: after a grazing one nothing is linear


def shot(design: Design, fitted: Fit, records: Sequence[Record]) -> Fit:
    """Return a fit whose coefficients minimize the error of free runs.

    Parameters
    ----------
    design : Design
        The model, with p columns.
    fitted : Fit
        Coefficients to begin with.
    records : sequence of Record
        Training records.

    Returns
    -------
    Fit
        The same one where the model cannot follow the records, or where neither short stretches
        nor the derivative speak for a change.
    """
    if not design.columns or sum(len(record) for record in records) > MAX_ROWS:
        return fitted
    shooting = _begun(design, fitted.coef, records)
    if shooting is None:
        return fitted
    coef = shooting.settled().coef
    before, after = (_judged(design, c, records) for c in (fitted.coef, coef))
    if not after < before:
        return fitted
    intervals = fitted.intervals + (coef - fitted.coef)[:, None]
    return Fit(coef, intervals, "simulation")


def _judged(design: Design, coef: np.ndarray, records: Sequence[Record]) -> float:
    """Return the product of both square errors: what one loses the other must gain, and more.

    Where a model lacks something, runs can be bettered by coefficients that are wrong.
    """
    misses = stretch_misses(design.equations(coef), records, JUDGED)
    return misses * derivative_square(design, records, coef)


def _begun(design: Design, coef: np.ndarray, records: Sequence[Record]) -> _Shooting | None:
    """Run over the longest stretches that a model can follow; None if there are none."""
    for n_stretches in N_STRETCHES:
        part = segments(records, design.velocities, n_stretches, max_rows=None)
        starts = part.z[:, 0, : part.n_states]
        x = _run(design, coef, starts, part, records)
        missed = np.sqrt(np.mean((part.z[:, :, : part.n_states] - x) ** 2, axis=(0, 1)))
        if np.all(missed < FAITHFUL * part.state_scale):  # False for NaN too
            scale = np.maximum(missed, 1e-9 * part.state_scale)
            return _Shooting(design, tuple(records), part, scale, coef, starts, x)
    return None


def _run(
    design: Design,
    coef: np.ndarray,
    starts: np.ndarray,
    part: Segments,
    records: Sequence[Record],
) -> np.ndarray:
    """Run over all stretches; NaN from where a run diverges."""
    length, equations = part.z.shape[1], design.equations(coef)
    pieces = (records[i][row : row + length] for i, row in part.places)
    runs = [
        free_run(equations, piece, start, on_divergence="nan", tolerance=1e-6)
        for piece, start in zip(pieces, starts, strict=True)
    ]
    return np.array(runs)


@dataclass(frozen=True, eq=False)
class _Shooting:
    """Runs over stretches with some coefficients; misses count in units of a scale."""

    design: Design
    records: tuple[Record, ...]
    part: Segments
    scale: np.ndarray
    coef: np.ndarray
    starts: np.ndarray
    x: np.ndarray

    @property
    def miss(self) -> np.ndarray:
        return (self.part.z[:, :, : self.part.n_states] - self.x) / self.scale

    @property
    def error(self) -> float:
        return float(np.sum(self.miss**2))

    def settled(self) -> _Shooting:
        """Take steps until they gain nothing more."""
        now = self
        for _ in range(MAX_STEPS):
            after = now.stepped()
            if after is None:
                break
            gain, now = 1.0 - after.error / max(now.error, 1e-300), after
            if gain < SETTLED:
                break
        return now

    def stepped(self) -> _Shooting | None:
        """Take one step; None if even a short one does not better the error."""
        change = self.gauss_newton()
        if change is None:
            return None
        for share in SHORTENED:
            coef, starts = (
                old + share * new for old, new in zip((self.coef, self.starts), change, strict=True)
            )
            x = _run(self.design, coef, starts, self.part, self.records)
            after = replace(self, coef=coef, starts=starts, x=x)
            if after.error < self.error:  # False for NaN
                return after
        return None

    def gauss_newton(self) -> tuple[np.ndarray, np.ndarray] | None:
        """Return changes of coefficients and starts; None if the runs forget how they began."""
        n_stretches, length, _ = self.x.shape
        keep = max(1, n_stretches * length // ROWS)
        free, response = self.sensitivities(keep)
        if np.max(np.abs(free)) > MAX_GROWTH:
            return None
        miss = self.miss[:, : (length - 1) // keep * keep + 1 : keep].reshape(n_stretches, -1, 1)
        # The starts of each stretch are eliminated first, so that few unknowns are left.
        basis, _ = np.linalg.qr(free)
        columns, target = (
            (part - basis @ (np.swapaxes(basis, 1, 2) @ part)).reshape(-1, part.shape[-1])
            for part in (response, miss)
        )
        size = np.maximum(np.linalg.norm(columns, axis=0), 1e-300)
        change = np.linalg.lstsq(columns / size, target[:, 0], rcond=1e-8)[0] / size
        moved = np.linalg.pinv(free) @ (miss - (response @ change)[..., None])
        return change, moved[..., 0] * self.scale

    def sensitivities(self, keep: int) -> tuple[np.ndarray, np.ndarray]:
        """Return what the runs owe to their starts and to the coefficients, as in `respond`."""
        inputs = self.part.z[:, :, self.part.n_states :]
        along = replace(self.part, z=np.concatenate([self.x, inputs], axis=2))
        slopes = jacobian(self.design.equations(self.coef), along.z, self.part.state_scale)
        driven = forces(along, self.design, self.design.columns, weighed=False)[..., :-1]
        return respond(slopes, driven, self.part.dt, self.scale, keep, _jumps(self.x, self.part))


def _jumps(x: np.ndarray, part: Segments) -> np.ndarray:
    """Return what becomes of a deviation where a velocity goes through zero, as factors.

    The friction turns sooner or later than without the deviation, which the ratio of the
    accelerations after and before multiplies. Of a body that sticks no deviation is left.
    """
    jumps = np.ones_like(x)
    for state in part.velocities:
        v = x[:, :, state]
        rate = np.diff(v, axis=1)
        turns = (v[:, 1:-2] * v[:, 2:-1] <= 0.0) & (v[:, 1:-2] != 0.0)
        before = np.where(rate[:, :-2] == 0.0, 1e-300, rate[:, :-2])
        ratio = np.clip(rate[:, 2:] / before, 0.0, LARGEST_JUMP)
        jumps[:, 1:-2, state] = np.where(turns, ratio, 1.0)
        jumps[:, :, state][v == 0.0] = 0.0
    return jumps
