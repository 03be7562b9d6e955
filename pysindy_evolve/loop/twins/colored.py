"""Twins whose sensors have all the noise: what free runs miss of the readings, and no force.

The noise of a sensor may be colored. It is in the states then, and in their derivative, and so a
function of the states predicts what a model leaves; in twins with white noise and a random force
none does.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...equations import Equations
from ...signals import Preparation, Record
from .paths import Path, follow
from .signs import Shuffle
from .twins import like

__all__ = ["ColoredTwins"]

LOUDEST = 5.0  # times the noise from one reading to the next, that slower noise of a sensor has


@dataclass(frozen=True, eq=False)
class ColoredTwins:
    """Makes twins of records, one for each random generator."""

    records: tuple[Record, ...]
    runs: tuple[Path, ...]
    made: tuple[Preparation, ...]
    noises: tuple[Shuffle, ...]

    @classmethod
    def of(cls, equations: Equations, records: Sequence[Record]) -> ColoredTwins | None:
        """Run the model along each record.

        Parameters
        ----------
        equations : Equations
            The model in which nothing is missing, fitted.
        records : sequence of Record
            What was measured.

        Returns
        -------
        ColoredTwins or None
            None if a record was not made from raw readings, or if a run does not stay so close to
            it that noise could be all that it misses.
        """
        runs = [follow(equations, record) for record in records]
        made = [record.preparation for record in records]
        free = [run for run in runs if run is not None and not run.push.any()]
        known = [one for one in made if one is not None]
        if len(free) < len(records) or len(known) < len(records):
            return None
        missed = [one.y - run.y for one, run in zip(known, free, strict=True)]
        for one, columns in zip(known, missed, strict=True):
            if np.any(columns.std(axis=0) > LOUDEST * one.noise):
                return None
        return cls(tuple(records), tuple(free), tuple(known), tuple(map(Shuffle.of, missed)))

    def make(self, rng: np.random.Generator) -> list[Record]:
        """Return one twin of each record."""
        parts = zip(self.records, self.runs, self.made, self.noises, strict=True)
        return [
            like(record, made.apply(made.t, run.y + noise.draw(rng)))
            for record, run, made, noise in parts
        ]
