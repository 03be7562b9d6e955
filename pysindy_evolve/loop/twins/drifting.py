"""Twins of trajectories: simulated, pushed about by a random force, and read by a noisy sensor.

The sizes of the force and of the sensor noise maximize the likelihood of the record, under the
model in which nothing is missing. The response to the force is that of the linearized model.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...equations import Equations
from ...signals import Record
from ...simulation import simulate
from ..fitting.residual import jacobian, respond
from ..fitting.trajectory import Disturbance, Trajectories, made_of
from ..given.design import Design

TOLERANCE = 1e-7  # of a simulation step


@dataclass(frozen=True, eq=False)
class DriftingTwins:
    """Makes twins of whole records, one for each random generator."""

    records: tuple[Record, ...]
    runs: tuple[np.ndarray, ...]
    slopes: tuple[np.ndarray, ...]
    disturbed: tuple[Disturbance, ...]

    @classmethod
    def of(cls, design: Design, records: Sequence[Record]) -> DriftingTwins:
        """Fit a model in which nothing is missing, and simulate it once along each record."""
        track = Trajectories(records, design, design.columns)
        equations = design.equations(track.fit()[0])
        runs = tuple(_run(equations, record) for record in records)
        slopes = tuple(
            jacobian(equations, _along(run, record), record.x.std(axis=0))
            for run, record in zip(runs, records, strict=True)
        )
        return cls(tuple(records), runs, slopes, tuple(track.disturbances()))

    @property
    def is_finite(self) -> bool:
        """Whether the simulations over all records are finite."""
        return all(bool(np.isfinite(run).all()) for run in self.runs)

    def make(self, rng: np.random.Generator) -> list[Record]:
        """Return one twin of each record.

        If the simulation over a record diverges, the record is its own twin, in which the search
        finds the same as in the record.
        """
        parts = zip(self.records, self.runs, self.slopes, strict=True)
        return [self._twin(*part, rng) if np.isfinite(part[1]).all() else part[0] for part in parts]

    def _twin(
        self, record: Record, run: np.ndarray, slope: np.ndarray, rng: np.random.Generator
    ) -> Record:
        made, (n, n_states) = made_of(record), run.shape
        push = np.zeros((1, n, n_states, 1))
        for state, disturbance in zip(
            range(made.order - 1, n_states, made.order), self.disturbed, strict=True
        ):
            push[0, :, state, 0] = disturbance.pushes(n, made.dt, rng)
        _, drift = respond(slope[None], push, made.dt, np.ones(n_states), 1)
        clean = (run + drift[0, :, 0].reshape(n, n_states))[:, :: made.order]
        noise = np.array([disturbance.sensor for disturbance in self.disturbed])
        noisy = replace(made, y=clean + noise * rng.standard_normal(clean.shape))
        return replace(noisy.apply(noisy.t, noisy.y), u=record.u)


def _run(equations: Equations, record: Record) -> np.ndarray:
    """Simulate over the raw times, (n_raw, n_states), from the first state of the record."""
    made, start = made_of(record), record.x[0]
    return simulate(equations, start, made.t, made.u, tolerance=TOLERANCE, on_divergence="nan")


def _along(run: np.ndarray, record: Record) -> np.ndarray:
    made = made_of(record)
    parts = [run] if made.u is None else [run, made.u]
    return np.column_stack([*parts, made.t])
