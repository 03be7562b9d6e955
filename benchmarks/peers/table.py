"""The rows as two tables in Markdown, with the ratios that matter and a note for each method."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from statistics import median
from typing import Any

OURS = "pysindy_evolve"
TITLES = {
    "frictionless": "Equation (3), without friction: 20 dB of noise on the acceleration",
    "friction": "Equation (7), with friction: 30 dB of noise on the acceleration",
}
HEAD = (
    "method", "exact", "coefficients off by", "validation error", "CPU", "CPU / ours",
    "memory above data", "memory / ours", "lines",
)  # fmt: skip

Row = dict[str, Any]


def as_markdown(rows: Sequence[Row], problems: Iterable[str]) -> str:
    """Return the tables of all problems, and the settings of each method below them."""
    labels = list(dict.fromkeys(row["method"] for row in rows))
    notes = {row["method"]: row["note"] for row in rows if "note" in row}
    parts = [_table(rows, labels, problem) for problem in problems]
    settings = [f"{i}. {label}: {notes.get(label, '')}" for i, label in enumerate(labels, 1)]
    return "\n\n".join([*filter(None, parts), "Settings:", "\n".join(settings)])


def _table(rows: Sequence[Row], labels: Sequence[str], problem: str) -> str:
    rows = [row for row in rows if row["problem"] == problem]
    good = [row for row in rows if "error" not in row]
    if not rows:
        return ""
    lines = [f"## {TITLES[problem]}"]
    if good:
        size = f"{good[0]['rows']} rows, {good[0]['data']:.0f} MB of data"
        seeds, loads = {row["seed"] for row in rows}, [row["load"] for row in good]
        lines += ["", f"{size}; medians of {len(seeds)} runs; machine load {median(loads):.1f}."]
    lines += ["", _line(HEAD), _line("---" for _ in HEAD)]
    ours = [row for row in good if row["method"] == OURS]
    for i, label in enumerate(labels, start=1):
        if group := [row for row in rows if row["method"] == label]:
            lines.append(_line([f"{label} [{i}]", *_cells(group, ours)]))
    return "\n".join(lines)


def _cells(group: Sequence[Row], ours: Sequence[Row]) -> list[str]:
    good = [row for row in group if "error" not in row]
    if not good:
        return [f"failed: {group[0]['error']}", *[""] * (len(HEAD) - 2)]
    counts = {said: sum(r["exact"] == said for r in good) for said in ("with offset", "invalid")}
    exact = [f"{sum(r['exact'] == 'yes' for r in good)} of {len(group)}"]
    exact += [f"{n} {said}" for said, n in counts.items() if n]
    off = [row["coefficient_error"] for row in good if row["coefficient_error"] is not None]
    errors = [row["validation_error"] for row in good if row["exact"] != "invalid"]
    cells = [", ".join(exact), *(f"{median(e):.2g} %" if e else "" for e in (off, errors))]
    for key, unit, digits in (("cpu", "s", 2), ("memory", "MB", 0)):
        value = median(row[key] for row in good)
        mine = median(row[key] for row in ours) if ours else 0.0
        cells += [f"{value:.{digits}f} {unit}", f"{value / mine:.2g}" if mine else ""]
    return [*cells, str(good[0]["lines"])]


def _line(cells: Iterable[str]) -> str:
    return "| " + " | ".join(cells) + " |"
