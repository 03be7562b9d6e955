"""Results of other packages on the same data, from `benchmarks/peers`, as a table like table 5."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from statistics import median
from typing import Any

from .tables import NONE, Table

TITLES = {
    "frictionless": "equation (3), 20 dB on the acceleration",
    "friction": "equation (7), 30 dB on the acceleration",
}
NUMBERS = {
    "coefficient_error": ("coefficients off by %", 2),
    "validation_error": ("error %", 3),
    "cpu": ("CPU s", 2),
    "memory": ("memory above the data MB", 0),
    "lines": ("lines", 0),
}

Row = dict[str, Any]


def read(path: Path) -> list[Table]:
    """Return one table for each problem that the file holds.

    Parameters
    ----------
    path : Path
        The rows that `benchmarks/peers` writes, JSON lines; it may be missing.

    Returns
    -------
    list of Table
        Medians of the runs of each method.
    """
    if not path.exists():
        return []
    rows = [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines() if line]
    problems = [title for title in TITLES if any(row["problem"] == title for row in rows)]
    return [_table(title, [row for row in rows if row["problem"] == title]) for title in problems]


def _table(problem: str, rows: Sequence[Row]) -> Table:
    methods = dict.fromkeys(row["method"] for row in rows)
    cells = [_cells(method, [row for row in rows if row["method"] == method]) for method in methods]
    header = ("method", "exact", *(name for name, _ in NUMBERS.values()))
    title = f"Table 5 with other packages, same rows, one thread: {TITLES[problem]}"
    return Table(f"table5_{problem}", title, header, tuple(cells), "Medians of the runs.")


def _cells(method: str, rows: Sequence[Row]) -> tuple[str, ...]:
    good = [row for row in rows if "error" not in row]
    exact = f"{sum(row['exact'] == 'yes' for row in good)} of {len(rows)}"
    numbers = []
    for key, (_, digits) in NUMBERS.items():
        values = [row[key] for row in good if row.get(key) is not None]
        numbers.append(f"{median(values):.{digits}f}" if values else NONE)
    return (method, exact if good else "failed", *numbers)
