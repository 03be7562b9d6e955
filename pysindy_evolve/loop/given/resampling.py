"""Records prepared again from their raw data, at another sampling time or another cutoff.

Records whose raw sampling times differ get one that is a multiple of each of them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...signals import Preparation, Record, as_target
from ...signals.prepare import LEAST_OVERSAMPLING, prepared

SEARCH_CUTOFF_RATIO = 2.0  # cutoff of the search, in cutoffs of the record ...
MAX_SAMPLING_RATE_SHARE = 0.4  # ... and at most, in sampling rates of the raw record
MOST_RAW = 100_000  # rows of all records up to which they are used undecimated
TOLERANCE = 0.01  # relative error of a multiple, as clocks are not exact
COARSER = 2.0  # largest common step over the one wanted; a coarser one is the user's choice
MULTIPLES = 4  # multiples of the longest raw sampling time that are searched at least


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
    again = [[_prepared_again(r, cutoff, step) for r in side] for side in (train, test)]
    return again[0], again[1]


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
        record if one.decimation == 1 else _prepared_again(record, one.cutoff, one.dt)
        for record, one in zip(records, made, strict=True)
    ]
    return fine[: len(train)], fine[len(train) :]


def _made(record: Record) -> Preparation | None:
    """Return how a record was made from raw data, or the motion that explains its target."""
    return record.preparation if record.motion is None else record.motion


def _prepared_again(record: Record, cutoff: float | None, step: float) -> Record:
    """Prepare a record again from its raw data, over the same span of time."""
    made = _made(record)
    if made is None:  # excluded by the caller
        return record
    settings = made.settings | {"cutoff": cutoff, "decimate": round(step / made.dt)}
    again = prepared(made.t, made.y, made.u, **settings)
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
    return [_prepared_again(record, cutoff, step) for record in records]


def common_step(raw: Sequence[float], wanted: float, cutoff: float | None) -> float:
    """Return a step near the one wanted that is a multiple of every raw sampling time.

    It is the longest one up to the step wanted or, if there is none, the shortest one beyond.

    Parameters
    ----------
    raw : sequence of float
        Raw sampling times of all records, units of t.
    wanted : float
        Step that the training records alone would have, units of t.
    cutoff : float or None
        Of the training records, cycles per unit of t; without one, nothing may be left out.

    Returns
    -------
    float
        Units of t.

    Raises
    ------
    ValueError
        If there is none up to twice the step wanted, or only one at which signals would alias.
    """
    longest, limit = max(raw), COARSER * wanted * (1.0 + TOLERANCE)
    multiples = [k * longest for k in range(1, max(MULTIPLES, int(limit / longest)) + 1)]
    shared = [step for step in multiples if all(_goes_into(one, step) for one in raw)]
    fits = [step for step in shared if all(_keeps(one, step, cutoff) for one in raw)]
    shorter = [step for step in fits if step <= wanted * (1.0 + TOLERANCE)]
    if shorter:
        return shorter[-1]
    if fits and fits[0] <= limit:
        return fits[0]
    times = " and ".join(f"{one:g}" for one in sorted({float(f"{one:.4g}") for one in raw}))
    band = "without cutoff" if cutoff is None else f"with a cutoff of {cutoff:.4g}"
    raise ValueError(
        "close_loop(train=..., test=...) must have raw sampling times that go into one step, near "
        f"the {wanted:g} of the training records; got {times}, {band}. {_advice(fits or shared)}"
    )


def _goes_into(raw: float, step: float) -> bool:
    """Tell whether a step is a multiple of a raw sampling time."""
    return abs(max(1, round(step / raw)) * raw / step - 1.0) <= TOLERANCE


def _keeps(raw: float, step: float, cutoff: float | None) -> bool:
    """Tell whether `prepare` can decimate to a step, with this cutoff, without aliasing."""
    factor = round(step / raw)
    if cutoff is None:
        return factor == 1
    most = max(1, int(1.0 / (LEAST_OVERSAMPLING * cutoff * raw)))
    return 2.0 * cutoff * raw < 1.0 and factor <= most


def _advice(steps: Sequence[float]) -> str:
    """Return how to make the shortest of some common steps possible, or what to do without one."""
    if not steps:
        return "Bring all records to one step with signals.resample."
    band = 1.0 / (LEAST_OVERSAMPLING * steps[0])
    return (
        f"Prepare all of them to a step of {steps[0]:g}, by `decimate`, with a cutoff of at most "
        f"{band:.3g}, or bring the records to one step with signals.resample."
    )
