"""The flags of each command, with their checks and their help."""

from __future__ import annotations

import argparse
import inspect
from collections.abc import Callable, Mapping
from importlib import metadata
from pathlib import Path
from typing import Any, NoReturn

from ..export.code import LANGUAGES
from ..library import OPERATORS, EvolvingLibrary
from ..loop import close_loop
from ..operators import BUILTIN
from . import reproduction
from .help_texts import ABOUT, EXAMPLES, FIT, FIT_EXAMPLES, LOOP, LOOP_EXAMPLES
from .readers import columns as columns_of
from .readers import constants, count, cutoff, folder, names, pair, pairs, turn

PROGRAM = "pysindy-evolve"


class _Parser(argparse.ArgumentParser):
    """A parser that reports an error in one line."""

    def error(self, message: str) -> NoReturn:
        self.exit(2, f"{self.prog}: error: {message}. See {self.prog} --help.\n")


Command = Callable[[argparse.Namespace], bool]


def make_parser(commands: Mapping[str, Command]) -> argparse.ArgumentParser:
    """Return the parser; the namespace it returns holds the function to call as `run`.

    Parameters
    ----------
    commands : mapping of str to callable
        Functions of the commands demo, fit, loop and paper.

    Returns
    -------
    argparse.ArgumentParser
    """
    plain = argparse.RawDescriptionHelpFormatter
    parser = _Parser(PROGRAM, description=ABOUT, epilog=EXAMPLES, formatter_class=plain)
    parser.add_argument("--version", action="version", version=_version())
    added = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    texts = {
        "demo": ("find dry friction in a simulated rig, no file needed", "", ""),
        "fit": ("evolve equations from a CSV file", FIT, FIT_EXAMPLES),
        "loop": ("correct a declared model by a CSV file", LOOP, LOOP_EXAMPLES),
        "paper": (
            "make the tables and figures of the paper again",
            reproduction.ABOUT,
            reproduction.EXAMPLES,
        ),
    }
    for name, (short, long, epilog) in texts.items():
        subparser = added.add_parser(
            name,
            help=short,
            description=long or f"{short[0].upper()}{short[1:]}.",
            epilog=epilog,
            formatter_class=plain,
            allow_abbrev=False,
        )
        subparser.set_defaults(run=commands[name])
        _OPTIONS[name](subparser)
        subparser.add_argument(
            "--seed", type=count(0), default=0, metavar="N", help="same seed, same result (0)"
        )
        subparser.add_argument("--quiet", action="store_true", help="show no progress bar")
        subparser.add_argument(
            "--traceback", action="store_true", help="say where an error came from"
        )
    return parser


def _add_demo(parser: argparse.ArgumentParser) -> None:
    saved = Path(f"{PROGRAM}-demo")
    parser.add_argument(
        "--output", type=folder, default=saved, metavar="FOLDER", help=f"what to save in ({saved})"
    )
    parser.set_defaults(max_effects=8)


def _add_fit(parser: argparse.ArgumentParser) -> None:
    columns = _add_columns(parser)
    states = columns.add_mutually_exclusive_group(required=True)
    states.add_argument(
        "--states", type=columns_of, default={}, metavar="q,v", help="columns of measured states"
    )
    states.add_argument(
        "--position",
        type=columns_of,
        default={},
        metavar="q,...",
        help="columns of positions, to be differentiated",
    )
    columns.add_argument(
        "--order",
        type=count(1),
        metavar="N",
        help="states for each position: 2 for position and velocity (2)",
    )
    search = parser.add_argument_group("search")
    search.add_argument(
        "--operators",
        type=names,
        default=OPERATORS,
        metavar="add,...",
        help=f"functions to build terms from ({','.join(OPERATORS)}); also "
        + ",".join(name for name in BUILTIN if name not in OPERATORS),
    )
    defaults = _defaults(EvolvingLibrary)
    for name, parameter, text in (
        ("--population", "population_size", "new terms in each generation"),
        ("--generations", "n_generations", "most generations"),
        ("--max-depth", "max_depth", "height of the tallest term"),
        ("--max-terms", "max_terms", "most terms in one equation"),
    ):
        default = defaults[parameter]
        search.add_argument(
            name, type=count(1), default=default, metavar="N", help=f"{text} ({default})"
        )


def _add_loop(parser: argparse.ArgumentParser) -> None:
    model = parser.add_argument_group("declared model")
    model.add_argument(
        "--equation",
        action="append",
        required=True,
        type=pair("--equation", "v = -k*q - c*v"),
        metavar="'STATE = TEXT'",
        help="derivative of a state; once for each, a position before its velocity",
    )
    model.add_argument(
        "--known", type=constants, default=(), metavar="m=1.2,...", help="constants with a value"
    )
    _add_columns(parser).add_argument(
        "--position",
        type=columns_of,
        default={},
        metavar="q,...",
        help="columns of positions, to be differentiated; without it every state is a column",
    )
    parser.set_defaults(states={})  # they are taken from the equations
    parser.add_argument("--report", type=folder, metavar="FOLDER", help="save report and picture")
    search = parser.add_argument_group("search")
    defaults = _defaults(close_loop)
    for name, kind, text in (
        ("significance", float, "chance to add an effect where nothing is missing"),
        ("n_twins", int, "simulated twins to test an effect on, at least 3/significance - 1"),
        ("min_share", float, "share of the explainable error that an effect must remove"),
        ("max_effects", int, "stop after so many effects"),
        ("n_jobs", int, "processes that work on the twins"),
    ):
        flag, default = f"--{name.removeprefix('n_').replace('_', '-')}", defaults[name]
        shown = f"{text} ({default or 1})"
        search.add_argument(flag, type=kind, default=default, metavar="N", help=shown)


def _defaults(call: Callable[..., Any]) -> dict[str, Any]:
    """Return the defaults of a call, which are those of the flags for its parameters."""
    return {name: one.default for name, one in inspect.signature(call).parameters.items()}


def _add_columns(parser: argparse.ArgumentParser) -> argparse._ArgumentGroup:
    """Add the files, their columns and the form of the result; return the group of columns."""
    parser.add_argument(
        "files", nargs="+", type=Path, metavar="FILE", help="CSV whose first line names its columns"
    )
    parser.add_argument(
        "--test",
        action="append",
        type=Path,
        default=[],
        metavar="FILE",
        help="record to judge on; may be repeated",
    )
    columns = parser.add_argument_group("columns")
    columns.add_argument("--time", default="t", metavar="NAME", help="column of time (t)")
    columns.add_argument(
        "--inputs",
        type=columns_of,
        default={},
        metavar="F,...",
        help="columns of inputs; F=NAME calls a column F, here and with states and positions",
    )
    columns.add_argument(
        "--target",
        type=pairs("--target", "v=acc"),
        default=(),
        metavar="STATE=COLUMN,...",
        help="measured derivatives; the others are computed. If all are measured, nothing is "
        "filtered unless --cutoff, --decimate or --held is given",
    )
    _add_preparation(columns)
    _add_format(columns)
    _add_result(parser)
    return columns


def _add_preparation(columns: argparse._ArgumentGroup) -> None:
    """Add the options to filter and decimate records, and to hold inputs between samples."""
    columns.add_argument(
        "--cutoff",
        type=cutoff,
        default="auto",
        metavar="HZ",
        help="low-pass, cycles per unit of t; auto takes it from the noise, none omits it (auto)",
    )
    columns.add_argument(
        "--decimate",
        type=count(1),
        metavar="N",
        help="keep every so many samples (eight or more per period of the cutoff)",
    )
    columns.add_argument(
        "--held",
        action="store_true",
        help="inputs keep their value until the next sample, as those of a controller do",
    )


def _add_format(columns: argparse._ArgumentGroup) -> None:
    """Add the options for the format of a file and for angles that jump back after a turn."""
    columns.add_argument(
        "--delimiter",
        default=",",
        type=lambda sign: "\t" if sign == "\\t" else sign,
        metavar="SIGN",
        help="character between the fields (,)",
    )
    columns.add_argument(
        "--decimal", default=".", choices=(".", ","), help="sign before the decimals (.)"
    )
    columns.add_argument(
        "--drop-empty",
        action="store_true",
        help="leave out the rows at the beginning and the end in which a needed column is empty",
    )
    columns.add_argument(
        "--unwrap",
        action="append",
        type=turn,
        default=[],
        metavar="ANGLE=TURN",
        help="angle that starts again after a whole turn, 360 or 6.283185, and is to go on "
        "instead; may be repeated",
    )


def _add_result(parser: argparse.ArgumentParser) -> None:
    result = parser.add_argument_group("result")
    result.add_argument("--latex", action="store_true", help="print the equations as LaTeX, too")
    result.add_argument(
        "--code", choices=LANGUAGES, metavar="LANGUAGE", help=f"print code: {', '.join(LANGUAGES)}"
    )


_OPTIONS = {
    "demo": _add_demo,
    "fit": _add_fit,
    "loop": _add_loop,
    "paper": reproduction.add_options,
}


def _version() -> str:
    try:
        return f"{PROGRAM} {metadata.version(PROGRAM)}"
    except metadata.PackageNotFoundError:
        return f"{PROGRAM} (not installed)"
