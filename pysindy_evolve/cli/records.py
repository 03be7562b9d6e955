"""Records from named columns of CSV files, angles among them unwrapped."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from ..loop import DeclaredModel
from ..loop.given.record_split import split_records
from ..signals import Record, prepare, read_csv
from ..signals.files import column_names
from ..signals.spectral import Array
from ..signals.wrapping import BEYOND


def derived_names(positions: Sequence[str], order: int) -> tuple[str, ...]:
    """Name positions and their derivatives: q, q_dot, q_ddot, q_d3."""
    endings = ["", "_dot", "_ddot", *(f"_d{k}" for k in range(3, order))][:order]
    return tuple(name + ending for name in positions for ending in endings)


def check_names(given: Namespace) -> None:
    """Raise if an option names a column that the first file does not have.

    Otherwise the error on a misspelled input would point at the model instead of the option.
    """
    held = column_names(given.files[0], given.delimiter)
    options = {"--time": [given.time]}
    options |= {f"--{one}": vars(given)[one].values() for one in ("position", "inputs")}
    for option, names in options.items():
        for name in (one for one in names if one not in held):
            raise ValueError(
                f"{option} must name columns of {str(given.files[0])!r}; got {name!r}. "
                f"The file holds {', '.join(map(repr, held))}."
            )


def order_of(states: Sequence[str], positions: Sequence[str]) -> int:
    """Return how many states there are for each measured position; 1 if all are measured."""
    if not positions:
        return 1
    order, rest = divmod(len(states), len(positions))
    if rest or tuple(states[::order]) != tuple(positions):
        raise ValueError(
            "--equation must be given for each position and then for its derivatives in turn; got "
            f"{', '.join(states)} for --position {','.join(positions)}. Sort or add equations."
        )
    return order


def check_derived(declared: DeclaredModel, order: int) -> None:
    """Raise if a state that is derived from the one before it is declared to be something else."""
    states, design = declared.states, declared.design()
    for place, state in enumerate(states):
        if (place + 1) % order and design.derivative_of(place) != place + 1:
            raise ValueError(
                f"--equation of {state} must be '{state} = {states[place + 1]}', as "
                f"{states[place + 1]} is derived from {state}; got another one. Correct it, or "
                "measure both and leave out --position."
            )


def read_split(given: Namespace, states: Sequence[str]) -> tuple[list[Record], list[Record]]:
    """Return records to fit on and records to judge on, held out as `close_loop` does."""
    check_apart(states, tuple(given.inputs))
    train, test = read_all(given, given.files, states), read_all(given, given.test, states)
    return split_records(train, test or None)


def read_all(given: Namespace, paths: Iterable[Path], states: Iterable[str]) -> list[Record]:
    """Read files, derive the states that were not measured, and filter all columns alike."""
    names = tuple(states)
    unknown = [state for state, _ in given.target if state not in names]
    if unknown:
        raise ValueError(
            f"--target must name states; got {unknown[0]!r}. Choose from {', '.join(names)}."
        )
    measured = given.position or given.states or {state: state for state in names}
    check_angles(given.unwrap, [*measured, *given.inputs])
    return [_read(path, given, names, measured) for path in paths]


def _read(
    path: Path, given: Namespace, states: tuple[str, ...], measured: Mapping[str, str]
) -> Record:
    targets, inputs = dict(given.target), tuple(given.inputs) or None
    signals = [*measured.values(), *given.inputs.values(), *targets.values()]
    wanted = dict.fromkeys([given.time, *signals])
    form = given.delimiter, given.decimal
    columns = read_csv(path, list(wanted), *form, drop_empty=given.drop_empty)
    for angle, turn in given.unwrap:
        column = {**measured, **given.inputs}[angle]
        columns[column] = unwrapped(columns[column], angle, turn)
    t, y = columns[given.time], np.column_stack([columns[name] for name in measured.values()])
    u = np.column_stack([columns[name] for name in given.inputs.values()]) if inputs else None
    no_filter = given.cutoff == "auto" and not given.decimate and not given.held
    if no_filter and set(targets) == set(states) == set(measured):
        # Everything was measured, so nothing is differentiated and no filter is needed.
        x_dot = np.column_stack([columns[targets[state]] for state in states])
        return Record(t, y, x_dot, u, states=states, inputs=inputs)
    settings = {"cutoff": given.cutoff, "decimate": given.decimate or "auto", "held": given.held}
    record = prepare(t, y, u, order=given.order, **settings)
    x_dot = record.x_dot.copy()
    for state, column in targets.items():
        if record.preparation is not None:
            x_dot[:, states.index(state)] = record.preparation.lowpass(columns[column])
    return replace(record, x_dot=x_dot, states=states, inputs=inputs)


def check_apart(states: Sequence[str], inputs: Sequence[str]) -> None:
    """Raise if two variables have the same name, or one has that of time."""
    names = [*states, *inputs]
    for name in names:
        if names.count(name) > 1 or name == "t":
            raise ValueError(
                f"--position, --states and --inputs must name each variable once, and t for time "
                f"only; got {name!r} again. Write another name before its column, as in F={name}."
            )


def check_angles(turns: Sequence[tuple[str, float]], known: Sequence[str]) -> None:
    """Raise if an angle to unwrap is not among the columns, or is given twice."""
    angles = [angle for angle, _ in turns]
    for angle in angles:
        if angle not in known:
            raise ValueError(
                f"--unwrap must name a measured state or an input; got {angle!r}. "
                f"Choose from {', '.join(known)}."
            )
        if angles.count(angle) > 1:
            raise ValueError(
                f"--unwrap must be given once for each angle; got {angle!r} "
                f"{angles.count(angle)} times. Keep the one whose turn is right."
            )


def unwrapped(column: Array, angle: str, turn: float) -> Array:
    """Return a column without its jumps after each turn; raise if its range exceeds a turn."""
    low, high = float(column.min()), float(column.max())
    if high - low > (1.0 + BEYOND) * turn:
        raise ValueError(
            f"--unwrap must name an angle that stays within its turn; got {angle!r} from {low:g} "
            f"to {high:g} with a turn of {turn:g}. Correct the turn, 360 for degrees and 6.283185 "
            "for radians, or leave out --unwrap if the angle goes on already."
        )
    return np.asarray(np.unwrap(column, period=turn))
