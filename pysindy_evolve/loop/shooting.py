"""Refine coefficients by the true simulation: multiple shooting.

The fit of the simulation error in `fit` is linear, about the measured states. Here the model runs
by itself over stretches of the record, as long as it stays close, and Gauss-Newton steps change its
coefficients, and the states in which the stretches begin, until it meets what was measured. Noise
of the sensor enters neither the states nor their derivatives of such a run, and biases nothing.

References
----------
Bock, Recent advances in parameter identification techniques for O.D.E., in: Numerical Treatment of
Inverse Problems in Differential and Integral Equations (1983), 95-121: multiple shooting.

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
from .runs import free_run
from .saltation import saltation
from .segments import Segments, segments

__all__ = ["shot"]

N_STRETCHES = (4, 8, 16, 32)  # of the training data; the fewest that the model can follow
FAITHFUL = 0.5  # standard deviations by which a run may miss
MAX_ROWS = 40_000  # a longer record costs too much, and its linear fit scatters little
ROWS = 2000  # of the runs that a step looks at
MAX_STEPS = 6  # of Gauss-Newton; two or three are the rule
SHORTENED = (1.0, 0.5, 0.25)  # a step that makes the error larger is tried again
SETTLED = 1e-3  # relative gain of a step after which no other one is taken


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
        The same one where the model cannot follow the records, or where what every second stretch
        says does not hold on those between.
    """
    if not design.columns or sum(len(record) for record in records) > MAX_ROWS:
        return fitted
    shooting = _begun(design, fitted.coef, records)
    if shooting is None:
        return fitted
    if not _holds(shooting):
        return fitted
    coef = shooting.settled().coef
    intervals = fitted.intervals + (coef - fitted.coef)[:, None]
    return Fit(coef, intervals, "simulation")


def _begun(design: Design, coef: np.ndarray, records: Sequence[Record]) -> _Shooting | None:
    """Run over the longest stretches that a model can follow; None if there are none."""
    length = 0
    for n_stretches in N_STRETCHES:
        part = segments(records, design.velocities, n_stretches, max_rows=None)
        if part.z.shape[1] == length:
            continue  # many short records are cut alike
        length = part.z.shape[1]
        starts = part.z[:, 0, : part.n_states]
        x = _run(design, coef, starts, part, records)
        missed = np.sqrt(np.mean((part.z[:, :, : part.n_states] - x) ** 2, axis=(0, 1)))
        if not np.all(missed < FAITHFUL * part.state_scale):  # so too for NaN
            continue
        scale = np.maximum(missed, 1e-9 * part.state_scale)
        shooting = _Shooting(design, tuple(records), part, scale, coef, starts, x)
        if np.max(np.abs(shooting.sensitivities(keep=shooting.keep)[0])) <= MAX_GROWTH:
            return shooting
    return None


def _holds(shooting: _Shooting) -> bool:
    """Tell whether steps on one half of the stretches better the other half, and the reverse.

    Where a model lacks something, runs can be bettered by coefficients that are wrong. So what the
    derivative loses counts against what the runs gain.
    """
    if len(shooting.x) < 2:
        return False
    before, after = 0.0, 0.0
    halves = [shooting.of(slice(k, None, 2)) for k in (0, 1)]
    for seen, judged in (halves, halves[::-1]):
        coef = seen.settled().coef
        losses = [
            derivative_square(shooting.design, shooting.records, c) for c in (shooting.coef, coef)
        ]
        before += judged.error * losses[0]
        after += judged.moved_to(coef, judged.starts).error * losses[1]
    return after < before


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

    @property
    def keep(self) -> int:
        """Every so many samples a step looks at."""
        return max(1, self.x.shape[0] * self.x.shape[1] // ROWS)

    def of(self, pick: slice) -> _Shooting:
        """Return some of the stretches."""
        return replace(self, part=self.part.picked(pick), starts=self.starts[pick], x=self.x[pick])

    def moved_to(self, coef: np.ndarray, starts: np.ndarray) -> _Shooting:
        """Run with other coefficients from other starts."""
        x = _run(self.design, coef, starts, self.part, self.records)
        return replace(self, coef=coef, starts=starts, x=x)

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
            after = self.moved_to(coef, starts)
            if after.error < self.error:  # False for NaN
                return after
        return None

    def gauss_newton(self) -> tuple[np.ndarray, np.ndarray] | None:
        """Return changes of coefficients and starts; None if the runs forget how they began."""
        n_stretches, length, _ = self.x.shape
        keep = self.keep
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
        equations, scale, dt = self.design.equations(self.coef), self.part.state_scale, self.part.dt
        slopes = jacobian(equations, along.z, scale)
        driven = forces(along, self.design, self.design.columns, weighed=False)[..., :-1]
        jumps = saltation(equations, along.z, scale, dt)
        return respond(slopes, driven, dt, self.scale, keep, jumps)
