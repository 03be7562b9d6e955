"""The records that the loop works on: checked, split, and brought to one sampling time."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations, permutations
from typing import Any

import numpy as np

from ...checks import SIZES
from ...signals import Preparation, Record, as_target, prepare
from .common_step import common_step
from .design import Design
from .rows import LARGEST, variables_of
from .through import with_functions

__all__ = ["alike", "check_records", "split_records", "undecimated", "widened"]

WIDER = 2.0  # cutoff of the search, in cutoffs of the record ...
HIGHEST = 0.4  # ... and at most, in sampling rates of the raw record
MOST_RAW = 100_000  # rows of all records that may be looked at undecimated


def split_records(
    train: Record | Sequence[Record], test: Record | Sequence[Record] | None
) -> tuple[list[Record], list[Record]]:
    """Return the records to fit on and those to judge on.

    Raises
    ------
    TypeError
        If something is neither a Record nor a list of them.
    ValueError
        If a list is empty, or the one record is too short to hold anything out.
    """
    fit_on, judge_on = _listed("train", train), [] if test is None else _listed("test", test)
    if judge_on:
        return fit_on, judge_on
    if len(fit_on) > 1:
        return fit_on[:-1], fit_on[-1:]
    first, last = fit_on[0].split(HELD_OUT)
    return [first], [last]


def _listed(parameter: str, given: Any) -> list[Record]:
    records = [given] if isinstance(given, Record) else given
    if not isinstance(records, list | tuple) or not all(isinstance(r, Record) for r in records):
        raise TypeError(
            f"close_loop({parameter}=...) must be a Record or a list of them; "
            f"got {type(given).__name__}. Make one with prepare(t, q, F)."
        )
    if not records:
        raise ValueError(
            f"close_loop({parameter}=...) must hold at least one record; got an empty list. "
            "Make one with prepare(t, q, F)."
        )
    return list(records)


MIN_SAMPLES = 32
HELD_OUT = 0.3  # share of a single record


def check_records(design: Design, records: Sequence[Record], whole: int = 0) -> None:
    """Raise where records do not fit the model, or are too short to hold anything out.

    Parameters
    ----------
    design : Design
        The declared model.
    records : sequence of Record
        To fit on and to judge on.
    whole : int
        Samples of the one record that all of them were cut from; 0 if there were several.

    Raises
    ------
    ValueError
        If a record does not fit the model in number, order or kind of its columns, is short or not
        uniformly sampled, or the model has no finite value on it.
    """
    for record in records:
        _check_counts(design, record)
        if record.n_samples < MIN_SAMPLES:
            cut = f" of {whole} samples, the last {100 * HELD_OUT:.0f} % of them held out"
            advice = "or pass `test`" if whole else "or prepare it with decimate=1, which cuts less"
            raise ValueError(
                f"close_loop(train=..., test=...) must have at least {MIN_SAMPLES} samples a "
                f"record, held-out part included; got {record.n_samples}{cut if whole else ''}. "
                f"Record longer, {advice}."
            )
        steps = np.diff(record.t)
        if np.ptp(steps) > 0.01 * steps.mean():
            raise ValueError(
                "close_loop(train=..., test=...) must be sampled uniformly; "
                f"got steps from {steps.min():g} to {steps.max():g}. "
                "Interpolate the record to one sampling time first."
            )
    for record in with_functions(design, records):  # a low-pass of steps swings past their ends
        _check_finite(design, record)
    _doubt_clock(records)
    _check_names(design, records)
    _check_columns(design, records)
    _check_copies(design, records)
    _check_velocities(design, records)


def _doubt_clock(records: Sequence[Record]) -> None:
    """Warn where times begin so late that what depends on them is lost in an offset."""
    start, end = records[0].t[0], max(record.t[-1] for record in records)
    if abs(start) > LATE * (end - start):
        warnings.warn(
            f"close_loop(train=..., test=...): times begin at {start:.10g}, long after zero. A "
            "drift from there is next to constant, and the phase of a forcing needs all digits of "
            "its frequency. Subtract the first time of the first record from all of them.",
            stacklevel=4,
        )


def _check_counts(design: Design, record: Record) -> None:
    """Raise where a record has other numbers of columns than the model."""
    wanted = {"x": (len(design.states), record.n_states, "state")}
    wanted["u"] = (len(design.inputs), record.n_inputs, "input")
    for name, (expected, found, what) in wanted.items():
        if expected != found:
            advice = f"Declare each {what}, or prepare the records with the order of the model."
            if name == "u" and record.motion is None:
                measured = ", ".join(design.inputs)
                advice = f"Pass u to prepare(t, y, u), with the columns {measured} in this order."
                advice = advice if expected else "Name what acts in `inputs` of the model."
            raise ValueError(
                f"close_loop(train=..., test=...) must have one column of {name} for each "
                f"{what} of the model; got {found} for {expected}. {advice}"
            )


def _check_names(design: Design, records: Sequence[Record]) -> None:
    """Raise where a record has a column under a name that stands elsewhere in the model."""
    for record in records:
        for kind, wanted in (("states", design.states), ("inputs", design.inputs)):
            names = getattr(record, kind) or ()
            for name, own in zip(names, wanted, strict=False):
                if name != own and name in wanted:
                    raise ValueError(
                        f"close_loop(train=..., test=...) must have {kind} in the order of the "
                        f"model, {', '.join(wanted)}; got {', '.join(names)}. Reorder the columns "
                        "of the records, or the model."
                    )


def _check_velocities(design: Design, records: Sequence[Record]) -> None:
    """Raise where a state is the velocity of another, and stands under another name in the model.

    A name that is no state is a free parameter, so nothing else would say so.
    """
    for position, velocity in permutations(range(len(design.states)), 2):
        swapped = design.derivative_of(velocity) == position
        if not swapped and any(velocity in side.variables for side in design.sides_of(position)):
            continue
        if all(np.array_equal(r.x_dot[:, position], r.x[:, velocity]) for r in records):
            if swapped or design.derivative_of(position) is not None:
                raise ValueError(
                    "close_loop(declared=...) must have its states in the order of the records, "
                    "each position followed by its velocity; got "
                    f"{', '.join(design.states)}. Write them in that order."
                )
            q, v = design.states[position], design.states[velocity]
            free = [column.name for column in design.columns if column.parts[position].parts]
            raise ValueError(
                f"close_loop(declared=...) must use the velocity {v!r} in the equation of {q!r}, "
                f"as the records hold a position and its velocity; got free parameters: "
                f"{', '.join(free) or 'none'}. Write {q!r}: {v!r}, or prepare with order=1."
            )


LATE = 100.0  # times as long as all records, after which nobody counts from zero

ROUNDING = 1e-13  # of its size, that a filter makes a constant column vary by


def _check_columns(design: Design, records: Sequence[Record]) -> None:
    """Raise where a column says nothing, or is out of the range of the arithmetic."""
    rates = tuple(f"{state}'" for state in design.states)
    for name, called in (("x", design.states), ("u", design.inputs), ("x_dot", rates)):
        columns = [
            getattr(record, name) for record in records if record.u is not None or name != "u"
        ]
        if not columns:
            continue
        stacked = np.concatenate(columns)
        largest = np.abs(stacked).max(axis=0)
        for index in np.flatnonzero(
            (largest > 0.0) & ((largest < SIZES[0]) | (largest > SIZES[1]))
        ):
            raise ValueError(
                f"close_loop(train=..., test=...) must have a size between {SIZES[0]:g} and "
                f"{SIZES[1]:g} in each column of {name}; got {largest[index]:g} in "
                f"{called[index]}. Use other units."
            )
        spread = np.ptp(stacked, axis=0)
        still = largest == 0.0 if name == "x_dot" else spread <= ROUNDING * largest
        for index in np.flatnonzero(still):
            made = ", and declare a free constant for what it makes" if name == "u" else ""
            raise ValueError(
                f"close_loop(train=..., test=...) must have columns of {name} that vary; got "
                f"{stacked[0, index]:g} everywhere in {called[index]}. Drop it from the records "
                f"and from the model{made}."
            )


def _check_copies(design: Design, records: Sequence[Record]) -> None:
    """Raise where two states are the same column, given twice by mistake."""
    for first, second in combinations(range(len(design.states)), 2):
        if all(np.array_equal(r.x[:, first], r.x[:, second]) for r in records):
            raise ValueError(
                "close_loop(train=..., test=...) must have a column of its own for each state; got "
                f"the same values for {design.states[first]} and {design.states[second]}. "
                "Pass the column of each to prepare."
            )


def _check_finite(design: Design, record: Record) -> None:
    """Raise where the model has no value on a record, such as a logarithm of a negative state."""
    variables = variables_of(record)
    with np.errstate(all="ignore"):
        parts = [("known", design.known(variables))]
        parts += [(column.name, column.evaluate(variables)) for column in design.columns]
    for name, values in parts:
        bad = np.flatnonzero(~(np.abs(values) < LARGEST).all(axis=1))  # NaN is not below either
        if len(bad):
            what = "the known part" if name == "known" else f"what {name!r} multiplies"
            raise ValueError(
                f"close_loop(declared=...) must be finite on the records; got {what} without a "
                f"finite value at sample {bad[0]}. Write the model so that it holds there, or cut "
                "the record."
            )


def alike(train: list[Record], test: list[Record]) -> tuple[list[Record], list[Record]]:
    """Bring all records to one sampling time and, where they were prepared, to one cutoff.

    The cutoff is the geometric mean of those of the training records; the held-out ones follow.

    Raises
    ------
    ValueError
        If sampling times differ and a record was not made by `prepare`.
    """
    steps = np.array([record.dt for record in (*train, *test)])
    if np.ptp(steps) <= 0.01 * steps[0]:
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
    """Return records of a target at the sampling time of their raw data, if that is one for all.

    A target is measured with all that its sensor saw between two rows; a sign that changes there is
    known no better than the rows are apart, and would look like one that is rounded off.
    """
    records = [*train, *test]
    made = [one for one in map(_made, records) if one is not None]
    steps = np.array([one.dt for one in made])
    n_raw = sum(len(one.t) for one in made)
    if len(made) < len(records) or np.ptp(steps) > 0.01 * steps[0] or n_raw > MOST_RAW:
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
    again = _as_known(again, record, made) if record.motion is None else as_target(again)
    inside = np.flatnonzero((again.t >= record.t[0] - step) & (again.t <= record.t[-1] + step))
    return again[int(inside[0]) : int(inside[-1]) + 1]


def _as_known(again: Record, record: Record, made: Preparation) -> Record:
    """Return a record prepared again with what was known of its inputs."""
    plan = again.preparation
    kept = None if plan is None else replace(plan, steps=made.steps)
    known = replace(again, preparation=kept, held=record.held, through=record.through)
    return known.with_inputs(lambda _, u: u) if record.through else known


def widened(records: list[Record]) -> list[Record]:
    """Prepare records again with a higher cutoff, for a search that looks well below it.

    Terms are evaluated on filtered states, but the target is filtered after the machine evaluated
    them. What the two differ by near the cutoff is a function of the state, and looks like physics.
    """
    made = [record.preparation for record in records]
    steps = {m.dt for m in made if m is not None}
    cutoffs = [m.cutoff for m in made if m is not None and m.cutoff is not None]
    if len(cutoffs) < len(records) or max(steps) > 1.001 * min(steps):
        return records
    raw = max(steps)
    cutoff = min(WIDER * max(cutoffs), HIGHEST / raw)
    if cutoff <= max(cutoffs):
        return records
    step = raw * max(1, int(1.0 / (8.0 * cutoff * raw)))
    return [_prepared(record, cutoff, step) for record in records]
