"""Records prepared again from their raw data, at another sampling time or another cutoff."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...signals import Preparation, Record, as_target, prepare
from .common_step import TOLERANCE, common_step

__all__ = ["at_one_step", "undecimated", "widened"]

SEARCH_CUTOFF_RATIO = 2.0  # cutoff of the search, in cutoffs of the record ...
MAX_SAMPLING_RATE_SHARE = 0.4  # ... and at most, in sampling rates of the raw record
MOST_RAW = 100_000  # rows of all records up to which they are used undecimated


def at_one_step(train: list[Record], test: list[Record]) -> tuple[list[Record], list[Record]]:
    """Bring all records to one sampling time and, where they were prepared, to one cutoff.

    The cutoff is the geometric mean of those of the training records; the held-out ones follow.

    Raises
    ------
    ValueError
        If sampling times differ and a record was not made by `prepare`.
    """
    steps = np.array([record.dt for record in (*train, *test)])
    if np.ptp(steps) <= TOLERANCE * steps[0]:
        return train, test
    made = [one for one in map(_made, (*train, *test)) if one is not None]
    if len(made) < len(steps):
        raise ValueError(
            "close_loop(train=..., test=...) must have one sampling time in all records; "
            f"got {steps.min():g} to {steps.max():g}. Make all of them with prepare(t, y, u), or "
            "interpolate them."
        )
    cutoffs = [one.cutoff for one in made[: len(train)] if one.cutoff]
    cutoff = float(np.exp(np.mean(np.log(cutoffs)))) if len(cutoffs) == len(train) else None
    step = float(np.quantile(steps[: len(train)], 0.5, method="lower"))  # one of them
    step = common_step([one.dt for one in made], step, cutoff)
    return [_prepared(r, cutoff, step) for r in train], [_prepared(r, cutoff, step) for r in test]


def undecimated(train: list[Record], test: list[Record]) -> tuple[list[Record], list[Record]]:
    """Return records of a target at the sampling time of their raw data, if all share it.

    A decimated target holds what its sensor saw between two rows. A sign that changes there is only
    known to within a row, and would look rounded off.
    """
    records = [*train, *test]
    made = [one for one in map(_made, records) if one is not None]
    steps = np.array([one.dt for one in made])
    n_raw = sum(len(one.t) for one in made)
    if len(made) < len(records) or np.ptp(steps) > TOLERANCE * steps[0] or n_raw > MOST_RAW:
        return train, test
    fine = [
        record if one.decimation == 1 else _prepared(record, one.cutoff, one.dt)
        for record, one in zip(records, made, strict=True)
    ]
    return fine[: len(train)], fine[len(train) :]


def _made(record: Record) -> Preparation | None:
    """Return how a record was made from raw data, or the motion that explains its target."""
    return record.preparation if record.motion is None else record.motion


def _prepared(record: Record, cutoff: float | None, step: float) -> Record:
    """Prepare a record again from its raw data, over the same span of time."""
    made = _made(record)
    if made is None:  # excluded by the caller
        return record
    settings = made.settings | {"cutoff": cutoff, "decimate": round(step / made.dt)}
    again = prepare(made.t, made.y, made.u, **settings)
    again = _with_known_inputs(again, record, made) if record.motion is None else as_target(again)
    inside = np.flatnonzero((again.t >= record.t[0] - step) & (again.t <= record.t[-1] + step))
    return again[int(inside[0]) : int(inside[-1]) + 1]


def _with_known_inputs(again: Record, record: Record, made: Preparation) -> Record:
    """Return a record prepared again with what was known of its inputs."""
    plan = again.preparation
    kept = None if plan is None else replace(plan, steps=made.steps)
    known = replace(again, preparation=kept, held=record.held, through=record.through)
    return known.with_inputs(lambda _, u: u) if record.through else known


def widened(records: list[Record]) -> list[Record]:
    """Prepare records again with a higher cutoff, for a search that looks well below it.

    Terms are evaluated on filtered states, but the target is filtered after the machine evaluated
    them. Near the cutoff the difference depends on the state and could be mistaken for an effect.
    """
    made = [record.preparation for record in records]
    steps = {m.dt for m in made if m is not None}
    cutoffs = [m.cutoff for m in made if m is not None and m.cutoff is not None]
    if len(cutoffs) < len(records) or max(steps) > 1.001 * min(steps):
        return records
    raw = max(steps)
    cutoff = min(SEARCH_CUTOFF_RATIO * max(cutoffs), MAX_SAMPLING_RATE_SHARE / raw)
    if cutoff <= max(cutoffs):
        return records
    step = raw * max(1, int(1.0 / (8.0 * cutoff * raw)))
    return [_prepared(record, cutoff, step) for record in records]
