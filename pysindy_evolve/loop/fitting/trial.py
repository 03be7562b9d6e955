"""Trials of models: free runs over stretches, fitted to the record by multiple shooting.

Gauss-Newton steps change the coefficients of each model and the initial states of its runs until it
meets the record as well as it can. There the misses are linear in small changes, so held-out
errors, and errors for other targets, follow from small Gram matrices. The runs of many models over
the same stretches are made in one integration, unless the caller passes another runner.

References
----------
Bock, Recent advances in parameter identification techniques for O.D.E., in: Numerical Treatment of
Inverse Problems in Differential and Integral Equations (1983), 95-121: multiple shooting.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...checks import TINY
from ...equations import Equations
from ...lazily import lazily
from ...simulation.pieces import simulate_pieces
from ..given.design import Design
from ..given.segments import Segments
from ..given.sensor import is_observed
from .residual import MAX_GROWTH, forces, jacobian, respond
from .saltation import saltation

ROWS_PER_STEP = 2000  # about how many rows of the runs a step uses
N_STEPS = 12  # Gauss-Newton steps, shortened ones included
MAX_LATER_GROWTH = 2.0  # of deviations after the first quarter of a stretch, if it is not chaotic
SHORTER = 0.3  # factor for a step that made the error larger, when it is tried again
MIN_GAIN_SHARE = 1e-4  # stop when a step gains less than this share of the error


@dataclass(frozen=True, eq=False)
class Trial:
    """A model that runs over stretches.

    Attributes
    ----------
    design : Design
        The model, with p columns.
    part : Segments
        Target states, and the inputs as they act in this model.
    scale : ndarray of shape (n_states,)
        Unit of the error of each state.
    coef : ndarray of shape (p,)
        Coefficients.
    starts : ndarray of shape (n_stretches, n_states)
        Initial states of the runs.
    x : ndarray of shape (n_stretches, n, n_states)
        The runs.
    """

    design: Design
    part: Segments
    scale: np.ndarray
    coef: np.ndarray
    starts: np.ndarray
    x: np.ndarray

    @property
    def n_seen(self) -> int:
        """Number of measured states; hidden states come last, and their misses do not count."""
        return len(self.scale) - self.design.n_hidden

    @property
    def target(self) -> np.ndarray:
        """Target states, shape (n_stretches, n, n_states)."""
        return self.part.z[:, :, : self.part.n_states]

    @property
    def shown(self) -> np.ndarray:
        """The runs after the low-passes of the records, shape (n_stretches, n, n_states)."""
        return self.part.shown(self.x)

    @lazily
    def miss(self) -> np.ndarray:
        """Target minus runs, both as the sensors show them."""
        return self.part.miss_of(self.x)

    @lazily
    def error(self) -> float:
        """Sum of the squared misses; infinite if a run diverges."""
        with np.errstate(over="ignore", invalid="ignore"):
            misses = (self.miss / self.scale)[..., : self.n_seen]
            total = float(np.sum(misses**2))
        return total if np.isfinite(total) else np.inf

    def aimed_at(self, target: np.ndarray) -> Trial:
        """Return the trial with other target states."""
        z = np.concatenate([target, self.part.z[:, :, self.part.n_states :]], axis=2)
        return replace(self, part=replace(self.part, z=z))

    def picked(self, pick: slice) -> Trial:
        """Return the trial over some of the stretches."""
        return replace(self, part=self.part.picked(pick), starts=self.starts[pick], x=self.x[pick])

    def rows(self, most_growth: float = MAX_GROWTH) -> Rows | None:
        """Return the runs, linearized in the coefficients and the starts.

        None if a small deviation grows too much along any stretch, or along a typical (median) one
        by more than `most_growth`, and not only at once.
        """
        n_stretches, length, _ = self.x.shape
        keep = max(1, n_stretches * length // ROWS_PER_STEP)
        free, response = map(self._of_seen, self.sensitivities(keep))
        largest = np.max(np.abs(free), axis=2)
        if not np.max(largest) <= MAX_GROWTH or _keeps_growing(largest, most_growth):
            return None
        if self.part.limits is not None:
            observed = is_observed(self.x, self.part.limits, self.part.seen)
            observed = picked(observed[..., : self.n_seen], keep)
            free, response = free * observed, response * observed
        basis, _ = np.linalg.qr(free)
        return Rows(response, basis, np.linalg.pinv(free), self.scale, keep, self.n_seen)

    def _of_seen(self, rows: np.ndarray) -> np.ndarray:
        """Leave out the rows of states that were not measured."""
        n_stretches, n_rows, n_columns = rows.shape
        n_states = len(self.scale)
        of_states = rows.reshape(n_stretches, n_rows // n_states, n_states, n_columns)
        n_left = n_rows // n_states * self.n_seen
        return of_states[:, :, : self.n_seen].reshape(n_stretches, n_left, n_columns)

    def sensitivities(self, keep: int) -> tuple[np.ndarray, np.ndarray]:
        """Return the slopes of the runs in starts and in coefficients, as `respond` does."""
        inputs = self.part.z[:, :, self.part.n_states :]
        along = replace(self.part, z=np.concatenate([self.x, inputs], axis=2))
        equations, scale, dt = self.design.equations(self.coef), self.part.state_scale, self.part.dt
        slopes = jacobian(equations, along.z, scale)
        driven = forces(along, self.design, self.design.columns, weighed=False)[..., :-1]
        jumps = saltation(equations, along.z, scale, dt)
        return respond(slopes, driven, dt, self.scale, keep, jumps)

    def change(self) -> tuple[np.ndarray, np.ndarray] | None:
        """Return the Gauss-Newton step of coefficients and starts; None if runs grow too fast."""
        rows = self.rows()
        if rows is None or not np.isfinite(rows.response).all():
            return None
        miss = rows.of(self.miss)
        change = rows.change(rows.response, miss)
        return change, rows.starts(rows.response, miss, change)


Runner = Callable[[Sequence[Trial]], list[Trial]]


@dataclass(frozen=True, eq=False)
class Rows:
    """The runs of a trial, linearized in its coefficients and starts.

    Attributes
    ----------
    response : ndarray of shape (n_stretches, n_rows, p)
        Slopes of the runs in each coefficient.
    basis : ndarray of shape (n_stretches, n_rows, n_states)
        Orthonormal basis of the changes that starts can make.
    to_starts : ndarray of shape (n_stretches, n_states, n_rows)
        Maps rows to the change of the starts that explains them best.
    scale : ndarray of shape (n_states,)
        Unit of the error of each state.
    keep : int
        Number of samples from one row to the next.
    n_seen : int
        Number of states, the first ones, that were measured.
    """

    response: np.ndarray
    basis: np.ndarray
    to_starts: np.ndarray
    scale: np.ndarray
    keep: int
    n_seen: int

    def of(self, deviation: np.ndarray) -> np.ndarray:
        """Return deviations of the states, (n_stretches, n, n_states), as (..., n_rows, 1)."""
        return picked((deviation / self.scale)[..., : self.n_seen], self.keep)

    def without_starts(self, rows: np.ndarray) -> np.ndarray:
        """Project out of rows what the starts can explain."""
        return np.asarray(rows - self.basis @ (np.swapaxes(self.basis, 1, 2) @ rows))

    def change(self, response: np.ndarray, miss: np.ndarray, damping: float = 0.0) -> np.ndarray:
        """Return the change of parameters that explains a miss best, with the starts eliminated.

        Parameters
        ----------
        response : ndarray of shape (n_stretches, n_rows, p)
            Slopes of the runs in each parameter.
        miss : ndarray of shape (n_stretches, n_rows, 1)
            The miss to explain.
        damping : float
            Levenberg-Marquardt damping, relative to the square of each column.

        Returns
        -------
        ndarray of shape (p,)
        """
        pair = (response, miss)
        columns, target = (self.without_starts(part).reshape(-1, part.shape[-1]) for part in pair)
        size = np.maximum(np.linalg.norm(columns, axis=0), TINY)
        damped = np.vstack([columns / size, np.sqrt(damping) * np.eye(len(size))])
        wanted = np.append(target[:, 0], np.zeros(len(size)))
        return np.asarray(np.linalg.lstsq(damped, wanted, rcond=1e-8)[0] / size)

    def starts(self, response: np.ndarray, miss: np.ndarray, change: np.ndarray) -> np.ndarray:
        """Return the best change of the starts beside a change, shape (n_stretches, n_states)."""
        residual = miss - (response @ change)[..., None]
        return np.asarray((self.to_starts @ residual)[..., 0] * self.scale)


def picked(states: np.ndarray, keep: int) -> np.ndarray:
    """Return every `keep`-th sample of (n_stretches, n, n_states) as (n_stretches, n_rows, 1)."""
    last = (states.shape[1] - 1) // keep * keep
    return states[:, : last + 1 : keep].reshape(len(states), -1, 1)


def converged(trials: Sequence[Trial]) -> list[Trial]:
    """Run and fit coefficients and starts of all trials; those that diverge stay as they are."""
    return after_gauss_newton(runs_of(list(trials)))


def _keeps_growing(deviation: np.ndarray, most: float) -> bool:
    """Tell whether small deviations grow by more than `most` along a typical stretch, and go on.

    A stiff spring turns a small deviation into a large velocity at once, and lets it grow no
    further than in the first quarter.
    """
    first = -(-deviation.shape[1] // 4)
    at_once, whole = np.max(deviation[:, :first], axis=1), np.max(deviation, axis=1)
    return bool(np.median(whole) > most and np.median(whole / at_once) > MAX_LATER_GROWTH)


def after_gauss_newton(
    trials: Sequence[Trial],
    run: Runner | None = None,
    least_gain: float = MIN_GAIN_SHARE,
    n_steps: int = N_STEPS,
) -> list[Trial]:
    """Take Gauss-Newton steps from trials that have been run, until they gain nothing more.

    Parameters
    ----------
    trials : sequence of Trial
        Models with their initial runs; those that diverge stay as they are.
    run : callable, optional
        Makes the runs of moved trials; by default all in one integration.
    least_gain : float
        Stop when a step gains less than this share of the error.
    n_steps : int
        Steps at most.

    Returns
    -------
    list of Trial
    """
    run, found = run or runs_of, list(trials)
    active = {k: 1.0 for k, trial in enumerate(found) if np.isfinite(trial.error)}
    changes = {k: found[k].change() for k in active}
    for _ in range(n_steps):
        active = {k: share for k, share in active.items() if changes[k] is not None}
        if not active:
            break
        moved = run([_moved(found[k], changes[k], share) for k, share in active.items()])
        for (k, share), after in zip(list(active.items()), moved, strict=True):
            gain = 1.0 - after.error / max(found[k].error, TINY)
            if gain <= 0.0:
                active[k] = share * SHORTER
                continue
            found[k] = after
            if gain < least_gain:
                del active[k]
            else:
                active[k], changes[k] = 1.0, after.change()
    return found


def _moved(trial: Trial, change: tuple[np.ndarray, np.ndarray] | None, share: float) -> Trial:
    if change is None:
        return trial
    coef, starts = trial.coef + share * change[0], trial.starts + share * change[1]
    return replace(trial, coef=coef, starts=starts)


def runs_of(trials: Sequence[Trial]) -> list[Trial]:
    """Run all trials, of equal stretches and states, in one integration."""
    if not trials:
        return []
    equations = [trial.design.equations(trial.coef) for trial in trials]
    first, part = equations[0], trials[0].part
    terms = tuple(dict.fromkeys(term for one in equations for term in one.terms))
    coef = np.zeros((len(trials), len(first.states), len(terms)))
    for rows, one in zip(coef, equations, strict=True):
        rows[:, [terms.index(term) for term in one.terms]] = one.coef
    z = np.concatenate([trial.part.z for trial in trials])
    starts = np.concatenate([trial.starts for trial in trials])
    shared = Equations(terms, coef[0], first.states, first.inputs)
    x = simulate_pieces(shared, coef, starts, z[:, :, -1], z[:, :, part.n_states : -1])
    return [replace(t, x=runs) for t, runs in zip(trials, np.split(x, len(trials)), strict=True)]
