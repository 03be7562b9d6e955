"""The command `paper`, which reproduces the tables and figures of the paper."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from pathlib import Path

from ..paper import PARTS, forget, plan, reproduce
from .output import progress, say
from .readers import choices, count

ABOUT = """\
Make the tables and figures of the ESparse paper again (Goharoodi et al. 2020,
doi 10.1155/2020/7286575), the paper's row beside ours. Each finished run is kept in the results
folder at once, so the same command goes on where it was stopped."""

EXAMPLES = """\
examples:
  Everything, 20 runs of each case:
    pysindy-evolve paper
  A look at everything, two runs of a few cases:
    pysindy-evolve paper --quick --output quick
  Table 2 alone, two runs at a time:
    pysindy-evolve paper --only table2 --jobs 2"""
FOLDER = Path("pysindy-evolve-paper")
PEERS = Path("results/peers/rows.jsonl")


def add_options(parser: ArgumentParser) -> None:
    """Add the options of the command."""
    parser.add_argument(
        "--output", type=Path, default=FOLDER, metavar="FOLDER", help=f"results folder ({FOLDER})"
    )
    parser.add_argument(
        "--runs", type=count(1), default=20, metavar="N", help="runs of each case (20)"
    )
    parser.add_argument("--quick", action="store_true", help="at most two runs of a few cases")
    parser.add_argument(
        "--only",
        type=choices(PARTS),
        default=PARTS,
        metavar="table2,...",
        help=f"some of {', '.join(PARTS)}",
    )
    parser.add_argument(
        "--peers",
        type=Path,
        default=PEERS,
        metavar="FILE",
        help=f"what benchmarks/peers wrote, to be shown with table 5 ({PEERS})",
    )
    parser.add_argument("--jobs", type=count(1), metavar="N", help="runs at a time (1)")
    parser.add_argument(
        "--fresh", action="store_true", help="run again what the folder has of an earlier version"
    )


def paper(given: Namespace) -> bool:
    """Run the trials that are not finished, print the tables, and say where the files are."""
    if given.fresh:
        forget(given.output)
    results = reproduce(
        given.output,
        plan(given.runs, first_seed=given.seed, quick=given.quick),
        given.only,
        peers_file=given.peers,
        n_jobs=given.jobs,
        progress=progress(given),
    )
    for table in results.tables:
        say(table.to_markdown())
    say(f"Tables, figures and report.md are in {given.output}.")
    if not results.finished:
        say("Not everything is finished; the same command goes on from here.")
    return results.finished
