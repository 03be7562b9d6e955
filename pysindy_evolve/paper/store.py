"""A file of finished trials, one on each line, so that an interrupted run loses none."""

from __future__ import annotations

import json
import os
from pathlib import Path

from .cases import Case
from .trials import Trial


class Store:
    """Finished trials in a file, each written as soon as it is added.

    Parameters
    ----------
    path : Path
        The file, in JSON lines. Its folder is created if it does not exist.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        path.parent.mkdir(parents=True, exist_ok=True)
        self._trials = {trial.case: trial for trial in _read(path)}

    def __contains__(self, case: Case) -> bool:
        return case in self._trials

    def __getitem__(self, case: Case) -> Trial:
        return self._trials[case]

    def add(self, trial: Trial) -> None:
        """Save a trial; it is on the disk when this returns."""
        line = json.dumps(trial.to_dict())
        with self.path.open("a", encoding="utf-8") as file:
            file.write(f"{line}\n")
            file.flush()
            os.fsync(file.fileno())
        self._trials[trial.case] = trial

    def of(self, cases: list[Case]) -> list[Trial]:
        """Return the trials of the cases that are finished, in order."""
        return [self._trials[case] for case in cases if case in self]


def _read(path: Path) -> list[Trial]:
    """Read complete lines; a half line that a killed run left is cut off the file."""
    if not path.exists():
        return []
    text = path.read_text(encoding="utf-8")
    complete, _, rest = text.rpartition("\n")
    if rest:
        path.write_text(complete + "\n" if complete else "", encoding="utf-8")
    return [Trial.from_dict(json.loads(line)) for line in complete.splitlines() if line]
