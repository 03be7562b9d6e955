"""A noise-free path close to a record, and the push that keeps the model on it.

An incomplete or chaotic model leaves the record after a while. Then it is simulated in pieces, each
from a measured state, and as long as they stay close. Each piece fades into the next. Meanwhile the
path is no solution of the model, but its derivatives are known exactly, and so is the push: their
difference from the model.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from math import comb

import numpy as np
from numpy.polynomial import Polynomial
from scipy.interpolate import CubicSpline

from ...checks import TINY
from ...equations import Equations
from ...hidden_states.memory_equations import MemoryEquations, with_memories
from ...signals import Preparation, Record
from ...simulation import simulate
from ...substitution import without_unused_inputs

# Largest RMS distance of a path from the record, in its standard deviations.
MAX_PATH_DISTANCE = 0.5
MIN_PIECE_SAMPLES = 64  # raw samples of a piece, at least: in less, little of the model shows
FADE = 4  # pieces fade into one another over 1/FADE of their length
TOLERANCES = (1e-10, 1e-7)  # limits, of a simulation step: far below noise that may be rounding
REFINEMENT = 4  # steps per raw sample of an input, by splines, where that is cheap
CHEAP = 160_000  # refined samples, at most


@dataclass(frozen=True, eq=False)
class Path:
    """A path close to a record, and the push that keeps the model on it.

    Attributes
    ----------
    y : ndarray of shape (n_raw, n_columns)
        Measured columns without noise, at the raw times.
    push : ndarray of shape (n_raw, n_columns)
        Highest derivative of y minus that of the model: zero except where pieces are joined.
    distance : ndarray of shape (n_columns,)
        RMS distance of the readings from y.
    """

    y: np.ndarray
    push: np.ndarray
    distance: np.ndarray


def follow(equations: Equations, record: Record) -> Path | None:
    """Simulate a model along a record, in the longest pieces that stay close to it.

    Parameters
    ----------
    equations : Equations
        The model.
    record : Record
        What was measured, with its preparation.

    Returns
    -------
    Path or None
        None if the record was not made from raw data, or if even short pieces stray.
    """
    made = record.preparation
    if made is None:
        return None
    if made.u is not None:
        equations, columns = without_unused_inputs(equations)
        made = replace(made, u=made.u[:, columns] if columns else None)
    course = _Course(with_memories(equations, ()), record, made)
    length = int(course.samples[-1] + 1 - course.samples[0])
    path = course.path(length)
    while path is None and length // 2 >= max(MIN_PIECE_SAMPLES, 2 * made.trim):
        length //= 2
        path = course.path(length)
    return path


@dataclass(frozen=True, eq=False)
class _Course:
    """A model beside the raw data of a record."""

    equations: Equations
    record: Record
    made: Preparation

    @cached_property
    def samples(self) -> np.ndarray:
        """Raw sample of each row of the record."""
        return np.rint((self.record.t - self.made.t[0]) / self.made.dt).astype(int)

    @cached_property
    def states(self) -> np.ndarray:
        """Initial states of runs from each row of the record: measured, then hidden ones."""
        if not isinstance(self.equations, MemoryEquations):
            return np.asarray(self.record.x)
        hidden = self.equations.along(self.record.x, self.record.u, self.record.t)
        return np.column_stack([self.record.x, hidden])

    @cached_property
    def refinement(self) -> int:
        """Steps in each raw sample."""
        if self.made.u is None:
            return 1
        return int(np.clip(CHEAP // len(self.made.t), 1, REFINEMENT))

    @cached_property
    def fine(self) -> tuple[np.ndarray, np.ndarray | None]:
        """Refined times and inputs: straight lines between samples would cut off their peaks."""
        t, u, steps = self.made.t, self.made.u, self.refinement
        if u is None:
            return t, u
        n = len(t)
        fine = np.interp(np.arange(steps * (n - 1) + 1) / steps, np.arange(n), t)
        spline = CubicSpline(t, u, axis=0)
        # Chords lie above a convex curve, by so much on average.
        chords = (self.made.dt / steps) ** 2 / 12.0 * spline(fine, 2)
        return fine, spline(fine) - chords

    @cached_property
    def tolerance(self) -> float:
        """Error of a simulation step: differentiated like the noise, it must be smaller."""
        noise = self.made.noise / np.maximum(self.made.y.std(axis=0), TINY)
        return float(np.clip(0.01 * noise.min(), *TOLERANCES))

    def path(self, length: int) -> Path | None:
        """Join pieces of a length in raw samples; None if they stray from the record."""
        # Beyond the record, the low-pass reaches no further than the preparation trims.
        first, stop = self.samples[0], min(self.samples[-1] + 1 + self.made.trim, len(self.made.t))
        joined = self._joined(length, stop)
        if joined is None:
            return None
        x, push = joined
        y = np.array(self.made.y, dtype=float)
        measured = x[:, : self.record.n_states : self.made.order]
        stray = measured - y[first:stop]
        seen = np.clip(measured, *self.made.limits) - y[first:stop]
        distance = np.sqrt(np.mean(seen**2, axis=0))
        if np.any(distance >= MAX_PATH_DISTANCE * y.std(axis=0)):
            return None
        y[:first] += stray[0]  # what lies outside only needs to join without a jump
        y[first:stop] += stray
        y[stop:] += stray[-1]
        return Path(y, push, distance)

    def _joined(self, length: int, stop: int) -> tuple[np.ndarray, np.ndarray] | None:
        """Return states from the first sample to a stop, and the push; None if not finite."""
        first, last = self.samples[[0, -1]]
        fade = length // FADE
        wanted = np.arange(first, max(first + 1, last + 1 - fade), length)
        rows = np.unique(np.searchsorted(self.samples, wanted))
        starts = self.samples[rows]
        ends = np.minimum(np.append(starts[1:] + fade, stop), stop)
        x = np.empty((stop - first, self.states.shape[1]))
        push = np.zeros(self.made.y.shape)
        for row, start, end in zip(rows, starts, ends, strict=True):
            piece = self._run(row, start, end)
            if start > first:
                overlap = slice(start, min(start + fade, end))
                old, new = (
                    x[overlap.start - first : overlap.stop - first],
                    piece[: overlap.stop - start],
                )
                piece[: len(old)], push[overlap] = self._fade(old, new, overlap)
            x[start - first : end - first] = piece
            if not (np.isfinite(piece).all() and np.isfinite(push[start:end]).all()):
                return None
        return x, push

    def _run(self, row: int, start: int, end: int) -> np.ndarray:
        """Simulate from a row, at raw sample `start`, to the last sample before `end`."""
        t, u = self.fine
        steps = self.refinement
        span = slice(start * steps, (end - 1) * steps + 1)
        return simulate(
            self.equations,
            self.states[row],
            t[span],
            None if u is None else u[span],
            tolerance=self.tolerance,
            on_divergence="nan",
        )[::steps]

    def _fade(self, old: np.ndarray, new: np.ndarray, at: slice) -> tuple[np.ndarray, np.ndarray]:
        """Fade from one solution to another; return states, and the push.

        With a weight w, the derivatives of the path follow from those of the two by Leibniz's
        rule: (w gap)^(m) = sum over k of binomial(m, k) w^(k) gap^(m - k).
        """
        order = self.made.order
        old_levels, new_levels = self._levels(old, at), self._levels(new, at)
        gap = [b - a for a, b in zip(old_levels, new_levels, strict=True)]
        weight = _weight(len(old), len(old) * self.made.dt, order)
        levels = [
            old_levels[m] + sum(comb(m, k) * weight[k] * gap[m - k] for k in range(m + 1))
            for m in range(order + 1)
        ]
        n = self.record.n_states
        x = np.stack(levels[:-1], axis=2).reshape(len(old), n)
        x = np.column_stack([x, old[:, n:] + weight[0] * (new[:, n:] - old[:, n:])])
        return x, levels[-1] - self._levels(x, at)[-1]

    def _levels(self, x: np.ndarray, at: slice) -> list[np.ndarray]:
        """Return the measured columns and all their derivatives, the last one by the model."""
        order = self.made.order
        u = None if self.made.u is None else self.made.u[at]
        with np.errstate(all="ignore"):  # the caller checks that they are finite
            rates = self.equations.evaluate(x, u, self.made.t[at])
        n = self.record.n_states
        levels = (x[:, level:n:order] for level in range(order))
        return [*levels, rates[:, order - 1 : n : order]]


def _weight(n: int, span: float, order: int) -> list[np.ndarray]:
    """Return a smooth step from 0 to 1 over a span of time, and its derivatives, each (n, 1)."""
    step = (Polynomial([0.0, 1.0, -1.0]) ** order).integ()  # no derivative jumps at the ends
    s = (np.arange(n)[:, None] + 0.5) / n
    return [step.deriv(k)(s) / step(1.0) / span**k for k in range(order + 1)]
