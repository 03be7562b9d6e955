"""Runs the trials that are not finished, then writes tables and figures into a results folder."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from joblib import Parallel, delayed
from tqdm.auto import tqdm

from . import peers
from .cases import Case, Plan
from .facts import PARTS
from .figures import draw
from .store import Store
from .tables import Table, make_tables
from .trials import Trial, run

TRIALS = "trials.jsonl"


@dataclass(frozen=True)
class Results:
    """The tables and figures that were written.

    Parameters
    ----------
    tables : tuple of Table
        Tables, made of the finished trials.
    figures : tuple of Path
        PNG files.
    finished : bool
        Whether every trial was run and every picture drawn.
    """

    tables: tuple[Table, ...]
    figures: tuple[Path, ...]
    finished: bool


def reproduce(
    folder: Path,
    plan: Plan,
    parts: Sequence[str] = PARTS,
    *,
    peers_file: Path | None = None,
    n_jobs: int | None = None,
    progress: bool = False,
) -> Results:
    """Reproduce tables and figures of the paper.

    Parameters
    ----------
    folder : Path
        Folder of the results. A trial that it already holds is not run again.
    plan : Plan
        Signal-to-noise ratios and seeds.
    parts : sequence of str
        Which of `PARTS`.
    peers_file : Path, optional
        Results of `benchmarks/peers`, shown with table 5 if they are there.
    n_jobs : int, optional
        Number of parallel processes, as in joblib.
    progress : bool
        Show a progress bar.

    Returns
    -------
    Results

    Notes
    -----
    Each trial is saved as soon as it is finished. Ctrl-C ends the trials; the tables are then made
    of the finished ones.
    """
    store = Store(folder / TRIALS)
    unfinished = [case for case in plan.cases(parts) if case not in store]
    finished = True
    figures: list[Path] = []
    try:
        for trial in tqdm(
            _trials(unfinished, n_jobs), "trial", len(unfinished), disable=not progress
        ):
            store.add(trial)
    except KeyboardInterrupt:
        finished = False
    tables = make_tables(parts, plan, store)
    if "table5" in parts and peers_file is not None:
        tables += peers.read(peers_file)
    for table in tables:
        table.save(folder)
    if finished:
        try:
            drawn = draw(parts, plan, store, folder)
            figures += tqdm(drawn, "figure", disable=not progress)
        except KeyboardInterrupt:
            finished = False
    _write_report(folder, tables, figures)
    return Results(tuple(tables), tuple(figures), finished)


def forget(folder: Path) -> None:
    """Remove the finished trials of a results folder, so that all are run again."""
    (folder / TRIALS).unlink(missing_ok=True)


def _trials(cases: Sequence[Case], n_jobs: int | None) -> Iterator[Trial]:
    """Run cases and yield each trial when it is finished."""
    if n_jobs in (None, 1):
        return map(run, cases)
    return Parallel(n_jobs=n_jobs, return_as="generator_unordered")(
        delayed(run)(case) for case in cases
    )


def _write_report(folder: Path, tables: Sequence[Table], figures: Sequence[Path]) -> None:
    """Write one page with all tables and figures."""
    parts = [table.to_markdown() for table in tables]
    parts += [f"![{path.stem}]({path.name})\n" for path in figures]
    (folder / "report.md").write_text("\n".join(parts), encoding="utf-8")
