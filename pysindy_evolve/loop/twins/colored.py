"""Twins without random forces: the whole error of free runs is taken for sensor noise.

Colored sensor noise is in the states and in their derivative. So a function of the states predicts
the residual, which none does in twins with white noise and a random force.
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

LOUDEST = 5.0  # error of a free run that may be noise, over noise from reading to reading


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
            None if a record was not made from raw readings, or if its free run strays further than
            sensor noise could.
        """
        runs = [follow(equations, record) for record in records]
        made = [record.preparation for record in records]
        free = [run for run in runs if run is not None and not run.push.any()]
        known = [preparation for preparation in made if preparation is not None]
        if len(free) < len(records) or len(known) < len(records):
            return None
        missed = [preparation.y - run.y for preparation, run in zip(known, free, strict=True)]
        for preparation, columns in zip(known, missed, strict=True):
            if np.any(columns.std(axis=0) > LOUDEST * preparation.noise):
                return None
        return cls(tuple(records), tuple(free), tuple(known), tuple(map(Shuffle.of, missed)))

    def make(self, rng: np.random.Generator) -> list[Record]:
        """Return one twin of each record."""
        parts = zip(self.records, self.runs, self.made, self.noises, strict=True)
        return [
            like(record, made.apply(made.t, run.y + noise.draw(rng)))
            for record, run, made, noise in parts
        ]
