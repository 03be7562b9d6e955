"""What a loader returns: records to fit on and records to judge on."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np

Folder = str | os.PathLike[str] | None  # the folder of measured sets; None searches, then downloads


@dataclass(frozen=True, eq=False)
class MeasuredRecord:
    """One raw measured record.

    Parameters
    ----------
    name : str
        Name of the record inside its set.
    t : ndarray of shape (n_samples,)
        Time in s.
    y : ndarray of shape (n_samples, n_outputs)
        Measured outputs, in the units that the loader states.
    u : ndarray of shape (n_samples, n_inputs) or None
        Measured inputs, in the units that the loader states.
    outputs : tuple of str
        Names of the columns of ``y``.
    inputs : tuple of str
        Names of the columns of ``u``.
    extras : mapping of str to ndarray of shape (n_samples,)
        Other columns of the source.
    constants : mapping of str to float
        Known constants of the rig of this record.
    """

    name: str
    t: np.ndarray
    y: np.ndarray
    u: np.ndarray | None = None
    outputs: tuple[str, ...] = ()
    inputs: tuple[str, ...] = ()
    extras: Mapping[str, np.ndarray] = field(default_factory=lambda: MappingProxyType({}))
    constants: Mapping[str, float] = field(default_factory=lambda: MappingProxyType({}))


@dataclass(frozen=True, eq=False)
class MeasuredSet:
    """Records to fit on and records to judge on.

    Parameters
    ----------
    train : tuple of MeasuredRecord
        Records for fitting.
    test : tuple of MeasuredRecord
        Records for judging, which must not influence any choice.
    """

    train: tuple[MeasuredRecord, ...]
    test: tuple[MeasuredRecord, ...]

    def __getitem__(self, name: str) -> MeasuredRecord:
        """Return the record of that name."""
        records = {record.name: record for record in (*self.train, *self.test)}
        if name not in records:
            raise KeyError(
                f"MeasuredSet[name] must be one of {sorted(records)}; got {name!r}. "
                "Choose one of them."
            )
        return records[name]
