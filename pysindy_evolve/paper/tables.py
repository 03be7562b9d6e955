"""A table as Markdown and CSV, and tables 2, 4, 5 and figure 10: the paper's row beside ours."""

from __future__ import annotations

import csv
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .cases import SNR_RIG, Plan
from .facts import CLEAN_DOWN_TO, TABLE_2, TABLE_4, TABLE_5, THEORY
from .store import Store
from .trials import Trial

NONE = "–"


@dataclass(frozen=True)
class Table:
    """A table of texts.

    Parameters
    ----------
    name : str
        Name of its files, without ending.
    title : str
        Text above the table.
    header : tuple of str
        Names of the columns.
    rows : tuple of tuple of str
        Cells.
    note : str
        Text below the table.
    """

    name: str
    title: str
    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    note: str = ""

    def to_markdown(self) -> str:
        """Return the table with its title and note, columns aligned."""
        cells = [self.header, *self.rows]
        widths = [max(len(row[j]) for row in cells) for j in range(len(self.header))]
        lines = [
            "| " + " | ".join(c.ljust(w) for c, w in zip(row, widths, strict=True)) + " |"
            for row in cells
        ]
        lines.insert(1, "|" + "|".join("-" * (w + 2) for w in widths) + "|")
        parts = [f"**{self.title}**", "\n".join(lines), self.note]
        return "\n\n".join(part for part in parts if part) + "\n"

    def save(self, folder: Path) -> None:
        """Write `name`.md and `name`.csv."""
        (folder / f"{self.name}.md").write_text(self.to_markdown(), encoding="utf-8")
        with (folder / f"{self.name}.csv").open("w", encoding="utf-8", newline="") as file:
            csv.writer(file).writerows([self.header, *self.rows])


def make_tables(parts: Sequence[str], plan: Plan, store: Store) -> list[Table]:
    """Return the tables of the parts, made of the finished trials."""
    found = []
    if "table2" in parts:
        found.append(table2(plan, store))
    if "figure10" in parts:
        found.append(figure10(plan, store))
    if "table4" in parts:
        found += [table4(plan, store), table4_by_noise(plan, store)]
    if "table5" in parts:
        found.append(table5(plan, store))
    return found


def table2(plan: Plan, store: Store) -> Table:
    """Return identified equations of the numerical oscillator, and their errors."""
    rows = []
    for snr, paper in TABLE_2.items():
        cases = [case for case in plan.for_table2() if case.snr_db == snr]
        fused, plain = (store.of([c for c in cases if c.fused is way]) for way in (True, False))
        ours = (_equation(fused), *_summary(fused), *_summary(plain))
        rows.append((f"{snr:g}", paper.equation, f"{paper.error:g}", *ours))
    plain_header = tuple(f"as measured: {name}" for name in _SUMMARY)
    return Table(
        "table2",
        "Table 2. The numerical Duffing oscillator, v′ identified at four signal-to-noise ratios",
        ("SNR dB", "paper", "error %", "here, first run", *_SUMMARY, *plain_header),
        tuple(rows),
        f"Theory: {THEORY}. {_ERRORS} The noise is on the acceleration. Here it is first joined "
        "with the slope of the velocity (`signals.fuse`); the last columns are fits to the "
        "acceleration as it was measured, at the floor of least squares.",
    )


def figure10(plan: Plan, store: Store) -> Table:
    """Return the numbers behind figure 10."""
    rows = []
    for snr in plan.figure10:
        trials = store.of([c for c in plan.for_figure10() if c.snr_db == snr])
        paper = "none" if snr >= CLEAN_DOWN_TO else "some"
        mean, deviation = accuracy(trials)
        clean = sum(not trial.extra for trial in trials)
        rows.append(
            (f"{snr:g}", paper, _share(clean, trials), _exact(trials), _number(mean, 2),
             _number(deviation, 2), _names(trials))
        )  # fmt: skip
    header = (
        "SNR dB", "extra terms in the paper", "here without any", "exact", "accuracy %",
        "standard deviation", "which were extra or missing",
    )  # fmt: skip
    return Table(
        "figure10",
        "Figure 10. Accuracy over signal-to-noise ratio",
        header,
        tuple(rows),
        "Accuracy is 100 % less the error against the clean validation acceleration.",
    )


def table4(plan: Plan, store: Store) -> Table:
    """Return identified equations of the rig with friction, one row for each experiment."""
    rows = []
    for experiment, paper in TABLE_4.items():
        trials = store.of([c for c in plan.for_table5() if c.experiment == experiment])
        rows.append(
            (f"{experiment}", paper.equation, f"{paper.error:g}", _equation(trials),
             *_summary(trials), _mean([t.measured_error for t in trials]))
        )  # fmt: skip
    return Table(
        "table4",
        f"Table 4. The rig with friction, two accelerometers with {SNR_RIG:g} dB each",
        ("exp.", "paper, measured", "error %", "here, first run", *_SUMMARY, "against measured %"),
        tuple(rows),
        "The paper's rows are of the laboratory; here its equation is the truth of a simulation. "
        + _ERRORS
        + " The last column is the mean error against the measured acceleration, as in the paper.",
    )


def table4_by_noise(plan: Plan, store: Store) -> Table:
    """Return the errors on the rig with friction over the signal-to-noise ratio."""
    noises = [("rig", snr) for snr in plan.table4] + [("friction", snr) for snr in plan.friction]
    rows = []
    for system, snr in noises:
        trials = store.of([c for c in plan.by_noise() if (c.system, c.snr_db) == (system, snr)])
        off = _number(max((t.coefficient_error for t in trials), default=np.nan), 1)
        seconds = _number(_median([t.seconds for t in trials]), 1)
        where = {"rig": "both accelerometers", "friction": "acceleration alone"}[system]
        rows.append((where, f"{snr:g}", *_summary(trials), off, seconds, _names(trials)))
    header = (
        "noise on", "SNR dB", *_SUMMARY, "coefficients off by at most %", "median s",
        "which were extra or missing",
    )  # fmt: skip
    title = "Table 4 over the noise, one run a seed, experiments in turn"
    return Table("table4_noise", title, header, tuple(rows))


def table5(plan: Plan, store: Store) -> Table:
    """Return run times and errors of the paper's three methods and of this package."""
    rows = [
        (f"paper: {method}", *(f"{s:g}" for s in seconds), *(f"{e:g}" for e in errors))
        for method, (seconds, errors) in TABLE_5.items()
    ]
    by_experiment = [store.of([c for c in plan.for_table5() if c.experiment == e]) for e in TABLE_4]
    seconds = [_number(_median([t.seconds for t in trials]), 1) for trials in by_experiment]
    errors = [_mean([t.measured_error for t in trials]) for trials in by_experiment]
    clean = [_mean([t.error for t in trials]) for trials in by_experiment]
    rows.append(("here: against measured data", *seconds, *errors))
    rows.append(("here: against clean data", *seconds, *clean))
    header = ("method", *(f"exp. {e}, s" for e in TABLE_4), *(f"exp. {e}, %" for e in TABLE_4))
    return Table(
        "table5",
        "Table 5. Run time and error on the rig with friction",
        header,
        tuple(rows),
        "The paper's times are of its authors' machine, ours processor seconds of one thread here "
        "(median of the runs), so only ratios within one machine can be compared.",
    )


_SUMMARY = ("mean error %", "largest", "exact")
_ERRORS = "Errors are against the clean validation acceleration, % of its standard deviation."


def _summary(trials: Sequence[Trial]) -> tuple[str, str, str]:
    errors = [trial.error for trial in trials]
    return _mean(errors), _number(max(errors, default=np.nan), 2), _exact(trials)


def accuracy(trials: Sequence[Trial]) -> tuple[float, float]:
    """Return mean and standard deviation of 100 % less the error."""
    if not trials:
        return np.nan, np.nan
    values = [100.0 - trial.error for trial in trials]
    return float(np.mean(values)), float(np.std(values, ddof=1 if len(values) > 1 else 0))


def _equation(trials: Sequence[Trial]) -> str:
    return trials[0].equation if trials else NONE


def _exact(trials: Sequence[Trial]) -> str:
    return _share(sum(trial.exact for trial in trials), trials)


def _share(count: int, trials: Sequence[Trial]) -> str:
    return f"{count} of {len(trials)}" if trials else NONE


def _names(trials: Sequence[Trial]) -> str:
    """Name the three most frequent extra (+) and missing (−) terms, with the number of runs."""
    signed = [f"+{name}" for trial in trials for name in trial.extra]
    signed += [f"−{name}" for trial in trials for name in trial.missing]
    counts = Counter(signed).most_common()
    shown = ", ".join(f"{name} ({count})" for name, count in counts[:3])
    return shown + (", …" if len(counts) > 3 else "") or NONE


def _mean(values: Iterable[float]) -> str:
    values = list(values)
    return _number(float(np.mean(values)) if values else np.nan, 2)


def _median(values: Sequence[float]) -> float:
    return float(np.median(values)) if values else np.nan


def _number(value: float, digits: int) -> str:
    return f"{value:.{digits}f}" if np.isfinite(value) else NONE
