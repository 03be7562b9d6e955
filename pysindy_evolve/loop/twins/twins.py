"""Twins: records of a machine that the declared model describes in full.

Whatever a search finds in a twin is a false alarm. A twin follows the model with the measured
input, and its sensor noise goes through the same preparation. The part of the residual that this
noise does not explain is added, times slow random signals: as strong and as colored as measured, at
the same times, but independent of the states, see signs.py.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ...checks import TINY
from ...equations import Equations
from ...signals import Preparation, Record
from ..fitting.residual import residual_on
from ..given.input_errors import jump_time_error
from ..given.sensor import as_observed
from .paths import Path, follow
from .signs import Shuffle

# Distance of a path from the readings, in units of what lies above the cutoff: if less, a part of
# that is motion. Both are estimates, so this is below one.
MIN_NOISE_SHARE = 0.8


@dataclass(frozen=True, eq=False)
class TwinMaker:
    """Makes twins of records, one for each random generator."""

    equations: Equations
    records: tuple[Record, ...]
    simulated: tuple[Path | None, ...]
    residuals: tuple[np.ndarray, ...]
    shuffles: tuple[Shuffle, ...]

    @classmethod
    def of(cls, equations: Equations, records: Sequence[Record]) -> TwinMaker:
        """Simulate the model once along each record.

        Parameters
        ----------
        equations : Equations
            The model in which nothing is missing, fitted. Its residual counts as disturbance: a
            bootstrap that imposes the null hypothesis keeps its level better (Davidson and
            MacKinnon 1999, DOI 10.1017/S0266466699153027).
        records : sequence of Record
            What was measured.

        Returns
        -------
        TwinMaker
        """
        residuals = tuple(residual_on(equations, record) for record in records)
        simulated = tuple(follow(equations, record) for record in records)
        shuffles = tuple(map(Shuffle.of, residuals))
        return cls(equations, tuple(records), simulated, residuals, shuffles)

    @cached_property
    def _inputs_at_work(self) -> list[int]:
        """Return the inputs that the model depends on, without probes."""
        n_states, n_inputs = len(self.equations.states), len(self.equations.inputs)
        used = frozenset().union(*(term.variables for term in self.equations.terms))
        return [k for k in range(n_inputs) if n_states + k in used]

    def make(self, rng: np.random.Generator) -> list[Record]:
        """Return one twin of each record."""
        parts = zip(self.records, self.simulated, self.residuals, self.shuffles, strict=True)
        return [self._twin(*part, rng) for part in parts]

    def _twin(
        self,
        record: Record,
        path: Path | None,
        residual: np.ndarray,
        shuffle: Shuffle,
        rng: np.random.Generator,
    ) -> Record:
        twin, explained = record, np.zeros_like(residual)
        if path is not None and record.preparation is not None:
            twin = like(record, _measured(record.preparation, path, rng))
        elif record.motion is not None:
            forces = self.equations.evaluate(record.x, record.u, record.t)
            twin = replace(record, u=_noisier(record, record.motion, rng), x_dot=forces)
        rates = self.equations.evaluate(twin.x, twin.u, twin.t)
        if twin is not record:
            explained = as_observed(twin, twin.x_dot - rates)
        explained = explained + self._of_jump_times(
            twin, rates, residual, explained.var(axis=0), rng
        )
        unexplained = np.maximum(residual.var(axis=0) - explained.var(axis=0), 0.0)
        share = np.sqrt(unexplained / np.maximum(residual.var(axis=0), TINY))
        disturbed = rates + explained + share * shuffle.draw(rng)
        return replace(twin, x_dot=disturbed)

    def _of_jump_times(
        self,
        twin: Record,
        rates: np.ndarray,
        residual: np.ndarray,
        noise: np.ndarray,
        rng: np.random.Generator,
    ) -> np.ndarray:
        """Return the effect of input jumps at random times, scaled to its share in the residual.

        The effect is confined to the few jumps, where sensor noise is no stronger than elsewhere.
        The share is measured with jumps that are all equally late. Drawn times would weigh most
        where the draw happens to be large, and underestimate it.
        """
        errors = (jump_time_error(twin, self._inputs_at_work, draw) for draw in (rng, None))
        drawn, typical = (self._change_of_rates(twin, rates, error) for error in errors)
        power = typical**2
        weights = power / np.maximum(np.sum(power, axis=0), TINY)
        unexplained = np.sum(weights * residual**2, axis=0) - noise
        expected = np.maximum(np.sum(weights * power, axis=0), TINY)
        share = np.clip(unexplained, 0.0, expected) / expected
        return np.asarray(drawn * np.sqrt(share))

    def _change_of_rates(
        self, twin: Record, rates: np.ndarray, error: np.ndarray | None
    ) -> np.ndarray:
        """Return by how much an error of the inputs changes the rates."""
        if error is None or twin.u is None:
            return np.zeros_like(rates)
        return as_observed(twin, self.equations.evaluate(twin.x, twin.u + error, twin.t) - rates)


def like(record: Record, twin: Record) -> Record:
    """Return a twin with the inputs of a record, and observed like it."""
    seen = None if record.seen is None else twin.seen
    return replace(twin, u=record.u, through=record.through, seen=seen)


def _measured(made: Preparation, path: Path, rng: np.random.Generator) -> Record:
    """Measure a path with a noisy sensor; subtract the push from the derivative.

    What lies above the cutoff counts as noise. It may be motion; then a path that has it too is
    closer to the readings than they are noisy.
    """
    is_motion = path.distance < MIN_NOISE_SHARE * made.noise
    noise = np.where(is_motion, path.distance, made.noise)
    noisy = path.y + noise * rng.standard_normal(path.y.shape)
    record = made.apply(made.t, noisy)
    if not path.push.any():
        return record
    x_dot = np.array(record.x_dot)
    x_dot[:, made.order - 1 :: made.order] -= made.lowpass(path.push)
    return replace(record, x_dot=x_dot)


def _noisier(record: Record, made: Preparation, rng: np.random.Generator) -> np.ndarray | None:
    """Return the motion that explains a force, with its sensor noise added once more."""
    linear = replace(made, limits=np.full_like(made.limits, np.inf) * [[-1.0], [1.0]])
    noise = linear.apply(made.t, made.noise * rng.standard_normal(made.y.shape))
    columns = np.column_stack([noise.x, noise.x_dot[:, made.order - 1 :: made.order]])
    return record.u if record.u is None else record.u + columns
