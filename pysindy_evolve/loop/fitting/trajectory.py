r"""Scores by the trajectory: for records that hold few independent numbers.

The derivative of fifty frames of a video is mostly noise, and so few numbers do not allow an
estimate of this noise from what all candidates together leave. But an equation y^(m) = f(x) can be
integrated m times, and then holds for the raw readings,

.. math:: y(t) = s(t) + \int \!\! \int f(x) + \int \!\! \int w + e,

with a start s, a polynomial of m coefficients, white noise e of the sensor, and a random force w
that disturbs the machine. The strength of w relative to e, and its correlation time, are two
numbers, which maximum likelihood finds even in a short record. f is evaluated on the filtered
states; the integrals average their noise away. All rows are fitted, so each coefficient is charged
with what a further one gains by chance.

======  ==============================================  ======================================
symbol  shape                                           meaning
======  ==============================================  ======================================
rows    (n, n_columns + 1)                              integrated columns and target of a record
grams   (n_noises, n_acting + 2, n_acting + 2)          inner products of the rows, weighed
logdets (n_noises,)                                     log determinants that go with them
======  ==============================================  ======================================

References
----------
Harville, JASA 72 (1977), DOI 10.1080/01621459.1977.10480998: variances by maximum likelihood.
Schaeffer and McCalla, Phys. Rev. E 96 (2017), DOI 10.1103/PhysRevE.96.023302: the integral form.
Akaike, IEEE Trans. Autom. Control 19 (1974), DOI 10.1109/TAC.1974.1100705: the charge.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import cast

import numpy as np
from scipy.integrate import cumulative_simpson
from scipy.signal import lfilter
from scipy.stats import t as student

from ...checks import TINY
from ...signals import Preparation, Record
from ...terms import Cache
from ..given.design import Column, Design
from ..given.rows import MAX_TERM_VALUE, variables_of
from .linear import errors_of, solve_gram
from .random_force import NOISES, drift_size, whitening

MAX_ROWS = 256  # of a record; more rows are averaged in groups, which loses little
# Least squared residual, relative to the square of the target: below it is rounding.
MIN_RELATIVE_SQUARE = 1e-14


def followable(design: Design, records: Sequence[Record]) -> bool:
    """Tell whether each open equation gives the highest derivative of a measured column."""
    orders = {None if r.preparation is None else r.preparation.order for r in records}
    if design.algebraic or orders not in ({1}, {2}):
        return False
    order = made_of(records[0]).order
    if design.open_states != tuple(range(order - 1, len(design.states), order)):
        return False
    return order == 1 or all(design.position_of(s) == s - 1 for s in design.open_states)


def made_of(record: Record) -> Preparation:
    """Return how a record was made from raw readings, as `followable` ones were."""
    return cast(Preparation, record.preparation)


@dataclass(frozen=True)
class Disturbance:
    """What disturbs one equation.

    Attributes
    ----------
    sensor : float
        Standard deviation of a reading, units of the measured column.
    force : float
        Standard deviation of the random force on each raw sample, units of the derivative.
    memory : float
        Correlation time of the force, units of t; 0 if it is white.
    """

    sensor: float
    force: float
    memory: float

    def pushes(self, n: int, dt: float, rng: np.random.Generator) -> np.ndarray:
        """Draw the force at n raw samples."""
        kept = np.exp(-dt / self.memory) if self.memory else 0.0
        drawn = self.force * np.sqrt(1.0 - kept**2) * rng.standard_normal(n)
        drawn[0] /= np.sqrt(1.0 - kept**2)
        return np.asarray(lfilter([1.0], [1.0, -kept], drawn))


@dataclass(frozen=True, eq=False)
class _Course:
    """One equation along all records, integrated: columns, then target."""

    rows: tuple[np.ndarray, ...]
    order: int

    @property
    def n_free(self) -> int:
        """Number of rows minus the number of coefficients of the starts."""
        return sum(len(rows) - self.order for rows in self.rows)

    @cached_property
    def acting(self) -> np.ndarray:
        """Places of the columns that are not zero in this equation, and of the target."""
        acts = np.any(np.concatenate(self.rows), axis=0)
        return np.flatnonzero(np.append(acts[:-1], True))

    @cached_property
    def grams(self) -> np.ndarray:
        """Inner products of a zero column, the acting columns and the target, for each noise."""
        acting_rows = [np.insert(rows[:, self.acting], 0, 0.0, axis=1) for rows in self.rows]
        return np.sum([whitening(len(r), self.order).grams(r) for r in acting_rows], axis=0)

    def gram(self, place: int) -> np.ndarray:
        """Return the inner products of all columns and the target for one of the noises."""
        n_columns = self.rows[0].shape[1]
        full = np.zeros((n_columns, n_columns))
        full[self.acting[:, None], self.acting] = self.grams[place, 1:, 1:]
        return full

    @cached_property
    def logdets(self) -> np.ndarray:
        return np.sum([whitening(len(r), self.order).logdets for r in self.rows], axis=0)

    def deviances(self, models: np.ndarray) -> np.ndarray:
        """Return -2 log likelihood at the best noise variance, (n_noises, n_models)."""
        places = np.zeros(self.rows[0].shape[1], dtype=int)
        places[self.acting] = np.arange(1, len(self.acting) + 1)
        distinct, inverse = np.unique(places[models], axis=0, return_inverse=True)
        least = MIN_RELATIVE_SQUARE * self.grams[:, -1, -1] + TINY
        squares = np.maximum(errors_of(self.grams, self.grams, distinct), least).T[
            :, inverse.ravel()
        ]
        return np.asarray(self.n_free * np.log(squares / self.n_free) + self.logdets[:, None])

    def likeliest(self) -> tuple[int, float]:
        """Return the place of the likeliest noise, and the variance of sensor noise."""
        n_columns = self.rows[0].shape[1] - 1
        place = int(np.argmin(self.deviances(np.arange(n_columns)[None])[:, 0]))
        gram = self.gram(place)
        square = gram[-1, -1] - solve_gram(gram) @ gram[:-1, -1]
        free = max(self.n_free - n_columns, 1)
        return place, float(max(square, MIN_RELATIVE_SQUARE * gram[-1, -1], TINY)) / free


class Trajectories:
    """Columns and target of each open equation, integrated along records.

    Parameters
    ----------
    records : sequence of Record
        All made by `prepare`.
    design : Design
        Supplies the known parts of the equations.
    columns : sequence of Column
        Columns of the design, then candidates.
    """

    def __init__(
        self, records: Sequence[Record], design: Design, columns: Sequence[Column]
    ) -> None:
        self.records, self.order = records, made_of(records[0]).order
        known, caches = Column("known", design.fixed), [Cache() for _ in records]
        self.courses = [
            _Course(
                tuple(
                    _integrated((*columns, known), state, record, cache)
                    for record, cache in zip(records, caches, strict=True)
                ),
                self.order,
            )
            for state in design.open_states
        ]

    def total(self, place: int) -> np.ndarray:
        """Return the Gram matrix for one of the noises, each equation in units of its target."""
        grams = [course.gram(place) for course in self.courses]
        return np.sum([gram / max(gram[-1, -1], TINY) for gram in grams], axis=0)

    def errors(self, models: np.ndarray) -> np.ndarray:
        """Return the variance that each model leaves, each with its own likeliest force.

        Parameters
        ----------
        models : ndarray of int of shape (n_models, n_columns)
            Columns of each model.

        Returns
        -------
        ndarray of shape (n_models, 1)
            Its logarithm is the information criterion per row.
        """
        models = np.asarray(models, dtype=int)
        deviance = np.sum([c.deviances(models).min(axis=0) for c in self.courses], axis=0)
        n_free = sum(c.n_free for c in self.courses)
        return np.exp((deviance + 2.0 * models.shape[1]) / n_free)[:, None]

    def fit(self) -> tuple[np.ndarray, np.ndarray]:
        """Fit all columns; return coefficients, shape (p,), and 95 % intervals, (p, 2)."""
        grams = []
        for course in self.courses:
            place, variance = course.likeliest()
            grams.append(course.gram(place) / variance)
        total = np.sum(grams, axis=0)
        coef = solve_gram(total)
        free = max(sum(c.n_free for c in self.courses) - len(coef), 1)
        size = np.sqrt(np.maximum(np.diagonal(total)[:-1], TINY))
        inverse = np.linalg.pinv(total[:-1, :-1] / np.outer(size, size), hermitian=True)
        half = student.ppf(0.975, free) * np.sqrt(np.diagonal(inverse)) / size
        return coef, np.column_stack([coef - half, coef + half])

    def disturbances(self) -> list[Disturbance]:
        """Return what disturbs each equation, if no column is missing."""
        found, record = [], self.records[0]
        group = _group(len(record))
        for course in self.courses:
            place, variance = course.likeliest()
            dt = group * record.dt
            noise, n = NOISES[place], len(course.rows[0])
            size = drift_size(n, self.order, noise.memory) * dt**self.order
            force = np.sqrt(variance * noise.ratio) / size
            if not noise.memory:  # the force on a raw sample that gives the same drift
                force *= np.sqrt(dt / made_of(record).dt)
            sensor = float(np.sqrt(variance * group))
            found.append(Disturbance(sensor, float(force), noise.memory * n * dt))
        return found


def _integrated(columns: Sequence[Column], state: int, record: Record, cache: Cache) -> np.ndarray:
    """Return integrated columns; the last one is replaced by the readings minus it."""
    variables, made = variables_of(record), made_of(record)
    rows, acting = np.zeros((len(record), len(columns))), []
    for place, column in enumerate(columns):
        values = column.values_in(state, variables, cache)
        if values is not None and np.all(np.abs(values) < MAX_TERM_VALUE):  # False for NaN too
            rows[:, place] = values
            acting.append(place)
    rates = rows[:, acting]
    for _ in range(made.order):
        rates = cumulative_simpson(rates, dx=record.dt, axis=0, initial=0.0)
    rows[:, acting] = rates
    samples = np.rint((record.t - made.t[0]) / made.dt).astype(int)
    rows[:, -1] = made.y[samples, state // made.order] - rows[:, -1]
    group = _group(len(rows))
    n_groups = len(rows) // group
    return rows[: n_groups * group].reshape(n_groups, group, -1).mean(axis=1)


def _group(n: int) -> int:
    """Return how many rows of a record are averaged."""
    return -(-n // MAX_ROWS)
