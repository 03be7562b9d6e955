"""A file of finished trials, one a line, so that an interrupted run loses none."""

from __future__ import annotations

import json
import os
from pathlib import Path

from .cases import Case
from .trials import Trial

__all__ = ["Store"]


class Store:
    """Finished trials in a file, each written as soon as it is there.

    Parameters
    ----------
    path : Path
        The file: JSON lines. It is made with its folder if it is not there.
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
        """Keep a trial: it is on the disk when this returns."""
        line = json.dumps(trial.to_dict())
        with self.path.open("a", encoding="utf-8") as file:
            file.write(f"{line}\n")
            file.flush()
            os.fsync(file.fileno())
        self._trials[trial.case] = trial

    def of(self, cases: list[Case]) -> list[Trial]:
        """Return those of the cases that are finished, in their order."""
        return [self._trials[case] for case in cases if case in self]


def _read(path: Path) -> list[Trial]:
    """Read what is whole; a run that was killed may have left half a line, which is cut off."""
    if not path.exists():
        return []
    text = path.read_text(encoding="utf-8")
    whole, _, rest = text.rpartition("\n")
    if rest:
        path.write_text(whole + "\n" if whole else "", encoding="utf-8")
    return [Trial.from_dict(json.loads(line)) for line in whole.splitlines() if line]
