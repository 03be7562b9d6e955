"""The output of the commands, on the terminal and in files."""

from __future__ import annotations

import sys
from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..equations import Equations
from ..export import to_code, to_latex
from ..loop import LoopReport
from ..loop.fitting.runs import nrmse, simulation_errors
from ..loop.report.number_text import percent_cell
from ..signals import Record

POOR = 50.0  # % NRMSE; both errors must exceed it, as one may be noise, the other chaos


def say(text: object = "") -> None:
    """Write to stdout without buffering, to keep the order with stderr."""
    sys.stdout.write(f"{text}\n")
    sys.stdout.flush()


def complain(text: str) -> None:
    """Write one line to stderr."""
    sys.stderr.write(f"{' '.join(text.split())}\n")


def progress(given: Namespace) -> bool:
    """Tell whether to show progress bars: on a terminal and without --quiet."""
    return sys.stderr.isatty() and not given.quiet


def print_errors(equations: Equations, records: Sequence[Record]) -> None:
    """Print derivative and free-run error of each state on held-out data."""
    x_dot = np.concatenate([record.x_dot for record in records])
    predicted = [equations.evaluate(record.x, record.u, record.t) for record in records]
    derivative = nrmse(np.concatenate(predicted) - x_dot, x_dot)
    say("\nErrors on held-out data, % of the standard deviation (NRMSE)")
    say(f"{'':<12}{'derivative':>16}{'free run':>16}")
    simulation = simulation_errors(equations, records)
    rows = zip(equations.states, derivative, simulation, strict=True)
    for state, *errors in rows:
        say(f"    {state:<8}" + "".join(f"{percent_cell(value):>16}" for value in errors))
    if not np.max(derivative) <= POOR and not np.max(simulation) <= POOR:  # true for NaN, too
        say(
            "\nThese equations do not predict what they were not fitted on: do not trust them. A "
            "longer record,\nother --operators or a smaller --max-terms may help; so does a model "
            "of your own, see the command loop."
        )


def print_code(model: Any, given: Namespace) -> None:
    """Print the model as LaTeX and as code, if asked for."""
    if given.latex:
        say(f"\n{to_latex(model)}")
    if given.code:
        say(f"\n{to_code(model, given.code)}")


def save(report: LoopReport, folder: Path) -> None:
    """Write the report and, if matplotlib is installed, its picture."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "report.txt").write_text(f"{report}\n", encoding="utf-8")
    say(f"Saved the report: {folder / 'report.txt'}")
    try:
        figure = report.plot()
    except ImportError as error:
        say(f"Saved no plot: {error}")
        return
    figure.savefig(folder / "residual.png", dpi=150)
    say(f"Saved the plot:   {folder / 'residual.png'}")
