"""The table of other packages on the same problem, if it was made."""

from __future__ import annotations

import csv
from pathlib import Path

from .tables import Table

__all__ = ["read"]

NAME = "peers.csv"


def read(folder: Path) -> Table | None:
    """Return the table in `peers.csv` of the results folder, or None if there is none.

    Parameters
    ----------
    folder : Path
        Results folder.

    Returns
    -------
    Table or None
    """
    path = folder / NAME
    if not path.exists():
        return None
    with path.open(encoding="utf-8", newline="") as file:
        rows = [tuple(row) for row in csv.reader(file) if row]
    if not rows:
        return None
    title = "Table 5 with other packages on the same rows, one thread"
    return Table("peers", title, rows[0], tuple(rows[1:]))
