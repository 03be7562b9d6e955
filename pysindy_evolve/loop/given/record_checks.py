"""Checks of the records that the loop is given; each error says what to do."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations, permutations, product

import numpy as np

from ...checks import SIZES
from ...signals import Record
from ...warn import warn
from .design import Design
from .input_functions import with_functions
from .record_split import HELD_OUT
from .resampling import TOLERANCE
from .rows import MAX_TERM_VALUE, variables_of

MIN_SAMPLES = 32
MAX_START_IN_LENGTHS = 100.0  # largest start time without a warning, in lengths of all records
MAX_CONSTANT_SPREAD = 1e-13  # relative variation that a filter leaves in a constant column


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
        if np.ptp(steps) > TOLERANCE * steps.mean():
            raise ValueError(
                "close_loop(train=..., test=...) must be sampled uniformly; "
                f"got steps from {steps.min():g} to {steps.max():g}. "
                "Interpolate the record to one sampling time first."
            )
    for record in with_functions(design, records):  # low-passed steps overshoot
        _check_finite(design, record)
    _doubt_clock(records)
    _check_names(design, records)
    _check_columns(design, records)
    _check_copies(design, records)
    _check_velocities(design, records)


def _doubt_clock(records: Sequence[Record]) -> None:
    """Warn if times begin so late that functions of them look like an offset."""
    start, end = records[0].t[0], max(record.t[-1] for record in records)
    if abs(start) > MAX_START_IN_LENGTHS * (end - start):
        warn(
            f"close_loop(train=..., test=...): times begin at {start:.10g}, long after zero. A "
            "drift from there is next to constant, and the phase of a forcing needs all digits of "
            "its frequency. Subtract the first time of the first record from all of them."
        )


def doubt_held_out(train: Sequence[Record], test: Sequence[Record]) -> None:
    """Warn where samples to judge on are samples that the model is fitted to.

    Parameters
    ----------
    train, test : sequence of Record
        To fit on, and to judge on.
    """
    for one, other in product(train, test):
        _, shared, in_other = np.intersect1d(one.t, other.t, return_indices=True)
        if len(shared) > 1 and np.array_equal(one.x[shared], other.x[in_other]):
            warn(
                f"close_loop(train=..., test=...): {len(shared)} samples of a test record are in a "
                "training record too, so errors on it are no held-out errors. Pass another record, "
                "or leave `test` out: the end of the training record is held out then."
            )
            return


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
            for name, declared_name in zip(names, wanted, strict=False):
                if name != declared_name and name in wanted:
                    raise ValueError(
                        f"close_loop(train=..., test=...) must have {kind} in the order of the "
                        f"model, {', '.join(wanted)}; got {', '.join(names)}. Reorder the columns "
                        "of the records, or the model."
                    )


def _check_velocities(design: Design, records: Sequence[Record]) -> None:
    """Raise if the equation of a position uses another name than that of its velocity.

    A name that is no state would pass as a free parameter.
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


def _check_columns(design: Design, records: Sequence[Record]) -> None:
    """Raise if a column is constant, or out of the range of the arithmetic."""
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
        still = largest == 0.0 if name == "x_dot" else spread <= MAX_CONSTANT_SPREAD * largest
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
        is_small = (np.abs(values) < MAX_TERM_VALUE).all(axis=1)  # False for NaN too
        bad = np.flatnonzero(~is_small)
        if len(bad):
            what = "the known part" if name == "known" else f"what {name!r} multiplies"
            raise ValueError(
                f"close_loop(declared=...) must be finite on the records; got {what} without a "
                f"finite value at sample {bad[0]}. Write the model so that it holds there, or cut "
                "the record."
            )
