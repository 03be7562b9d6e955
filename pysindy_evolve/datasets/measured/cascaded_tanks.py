"""Two cascaded tanks."""

from __future__ import annotations

import numpy as np

from .. import sources
from .record import Folder, MeasuredRecord, MeasuredSet


def load_cascaded_tanks(folder: Folder = None) -> MeasuredSet:
    """Two cascaded tanks that can overflow: pump voltage to lower level, every 4 s.

    Parameters
    ----------
    folder : path, optional
        Folder that holds ``cascaded_tanks/tanks.csv``; searched for, or downloaded, by default.

    Returns
    -------
    MeasuredSet
        Train: ``"estimation"``, test: ``"validation"``. y: lower level h in V of its sensor, which
        clips at 10 V; u: pump voltage in V. The level of the upper tank is not measured.

    Raises
    ------
    FileNotFoundError
        If `folder` is given and does not hold the file.
    ImportError
        If the file has to be downloaded and pooch is not installed.

    References
    ----------
    Schoukens, Noël, "Three benchmarks addressing open challenges in nonlinear system
    identification", IFAC-PapersOnLine 50, 2017, doi:10.1016/j.ifacol.2017.08.071.
    """
    columns = sources.read_columns("cascaded_tanks/tanks.csv", folder, _published)

    def record(name: str, part: str) -> MeasuredRecord:
        level = columns[f"y_{part}"]
        return MeasuredRecord(
            name=name,
            t=4.0 * np.arange(level.size),
            y=level[:, None],
            u=columns[f"u_{part}"][:, None],
            outputs=("h",),
            inputs=("u",),
        )

    return MeasuredSet(train=(record("estimation", "est"),), test=(record("validation", "val"),))


def _published() -> sources.Columns:
    """Pump voltage and level of both records.

    Returns
    -------
    dict of str to ndarray of shape (n_samples,)
        u and y in V, each for ``est`` and ``val``.
    """
    table = sources.read_csv(
        sources.fetch(
            "Rafa7046/Non_Linear_Identification",
            "e5c9b006b0a2ec1650bc018a5fb38d2f4363d4c7",
            "src/data/tanque.csv",
        )
    )
    public_names = {"u_est": "uEst", "y_est": "yEst", "u_val": "uVal", "y_val": "yVal"}
    return {name: table[public_name] for name, public_name in public_names.items()}
