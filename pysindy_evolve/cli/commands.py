"""The commands. Each returns True if it completed, False if it was interrupted."""

from __future__ import annotations

import time
from argparse import Namespace
from pathlib import Path
from textwrap import indent

import numpy as np
import pysindy as ps

from ..datasets import Drive, friction_drive
from ..export import format_equations
from ..library import EvolvingLibrary
from ..loop import DeclaredModel, LoopReport, close_loop
from ..optimizer import ElasticNet
from ..reading.library_terms import from_model
from ..signals import is_decided, prepare
from .options import PROGRAM
from .output import print_code, print_errors, progress, save, say
from .records import check_derived, check_names, derived_names, order_of, read_all, read_split


def demo(given: Namespace) -> bool:
    """Close the loop on a simulated axis whose declared model lacks dry friction."""
    start = time.perf_counter()
    drive = friction_drive(duration=5.0, random_state=given.seed)
    declared = DeclaredModel(drive.declared, inputs=drive.train.inputs)
    sides = "\n".join(f"{state}' = {side}" for state, side in drive.declared.items())
    say(
        "A simulated linear axis: motor force F in N, encoder position q in m with noise of 5e-6 m,"
        "\n5 s at 1 kHz to fit on, and 5 s of another motion to judge on. Declared is a model "
        f"without\ndry friction, with b and c free:\n{indent(sides, '    ')}\n"
    )
    train, test = (prepare(r.t, r.y, r.u) for r in (drive.train, drive.test))
    options = {"max_effects": given.max_effects, "progress": progress(given)}
    report = close_loop(declared, train, test, random_state=given.seed, **options)
    say(f"{report}\n\nThe truth, which the loop was not told")
    say(indent(format_equations(drive.equations), "    "))
    say(f"\nThis took {time.perf_counter() - start:.1f} s.")
    save(report, given.output)
    _save_records(drive, given.output)
    return _finished(report, given.max_effects)


def _save_records(drive: Drive, folder: Path) -> None:
    """Write the records as CSV and say how to do the same from the shell."""
    for record in (drive.train, drive.test):
        header = ",".join(("t", *record.outputs, *record.inputs))
        columns = (record.t, record.y, record.u)
        table = np.column_stack([column for column in columns if column is not None])
        path = folder / f"{record.name}.csv"
        np.savetxt(path, table, "%.12g", delimiter=",", header=header, comments="")
    sides = " ".join(f'--equation "{state} = {side}"' for state, side in drive.declared.items())
    say(
        "Saved the records, so that you can do the same from the shell:\n"
        f"    {PROGRAM} loop {folder / 'train.csv'} --test {folder / 'test.csv'} \\\n"
        f"        --position q --inputs F {sides}"
    )


def fit(given: Namespace) -> bool:
    """Evolve equations from files."""
    if given.order is not None and not given.position:
        raise ValueError(
            f"--order must come with --position; got {given.order} with --states. "
            "Name the measured positions, or leave it out."
        )
    given.order = (given.order or 2) if given.position else 1
    states = tuple(given.states) or derived_names(tuple(given.position), given.order)
    train, test = read_split(given, states)
    library = EvolvingLibrary(
        operators=given.operators,
        population_size=given.population,
        n_generations=given.generations,
        max_depth=given.max_depth,
        max_terms=given.max_terms,
        random_state=given.seed,
        progress=progress(given),
    )
    model = ps.SINDy(feature_library=library, optimizer=ElasticNet())
    rows = [is_decided(record) for record in train]
    x, x_dot, t, u = (
        [column[kept] for column, kept in zip(columns, rows, strict=True) if column is not None]
        for columns in ([getattr(r, name) for r in train] for name in ("x", "x_dot", "t", "u"))
    )
    names = [*states, *given.inputs]
    model.fit(x, t, x_dot=x_dot, u=u if given.inputs else None, feature_names=names)
    equations = from_model(model)
    say("Equations\n" + indent(format_equations(equations), "    "))
    print_errors(equations, test)
    print_code(model, given)
    return not library.interrupted_


def loop(given: Namespace) -> bool:
    """Correct a declared model by the records in files."""
    sides = dict(given.equation)
    if len(sides) != len(given.equation):
        raise ValueError(
            f"--equation must be given once for each state; got {len(given.equation)} of them for "
            f"{', '.join(sides)}. Join the terms of a state in one equation."
        )
    check_names(given)
    given.order = order_of(tuple(sides), tuple(given.position))
    declared = DeclaredModel(sides, inputs=tuple(given.inputs), known=dict(given.known))
    check_derived(declared, given.order)
    train, test = read_all(given, given.files, sides), read_all(given, given.test, sides)
    say(f"Free parameters: {', '.join(declared.parameters) or 'none'}\n")
    report = close_loop(
        declared,
        train,
        test or None,
        significance=given.significance,
        n_twins=given.twins,
        min_share=given.min_share,
        max_effects=given.max_effects,
        random_state=given.seed,
        n_jobs=given.jobs,
        progress=progress(given),
    )
    say(report)
    print_code(report, given)
    if given.report is not None:
        say()
        save(report, given.report)
    return _finished(report, given.max_effects)


def _finished(report: LoopReport, max_effects: int) -> bool:
    """Tell whether the search completed; reaching `max_effects` counts as well."""
    return report.finished or len(report.effects) >= max_effects
