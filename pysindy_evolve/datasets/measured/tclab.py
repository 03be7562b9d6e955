"""Heater board."""

from __future__ import annotations

import numpy as np

from .. import sources
from .record import Folder, MeasuredRecord, MeasuredSet

COMMITS = {
    "A": "196c74e5c50a00a6d873892e8d56b742d72dbd0b",
    "B": "f3d31fff371666f01b74813c4003385aa0d2b3be",
    "E": "f9a9d4b",
}


def load_tclab(folder: Folder = None) -> MeasuredSet:
    """Heater board with two heaters and two sensors, one step of the first heater, about 1 Hz.

    Parameters
    ----------
    folder : path, optional
        Folder that holds ``tclab/rec_A.csv`` and those of B and E; searched for, or downloaded,
        by default.

    Returns
    -------
    MeasuredSet
        Three boards: ``"B"`` trains, ``"E"`` and ``"A"`` test. y: temperatures T1, T2 in °C, in
        steps of 0.32 °C; u: first heater Q1 in %. The heater of board A has another power, so its
        gain must be fitted again; board E has an outlier in T2.

    Raises
    ------
    FileNotFoundError
        If `folder` is given and does not hold the file.
    ImportError
        If the file has to be downloaded and pooch is not installed.

    References
    ----------
    Kantor, TCLab: temperature control laboratory, https://github.com/jckantor/TCLab.
    """

    def record(name: str) -> MeasuredRecord:
        file = f"tclab/rec_{name}.csv"
        columns = sources.read_columns(file, folder, lambda: _published(name))
        return MeasuredRecord(
            name=name,
            t=columns["Time"],
            y=np.column_stack([columns["T1"], columns["T2"]]),
            u=columns["Q1"][:, None],
            outputs=("T1", "T2"),
            inputs=("Q1",),
        )

    return MeasuredSet(train=(record("B"),), test=(record("E"), record("A")))


def _published(board: str) -> sources.Columns:
    """Heater and temperatures of one board.

    Parameters
    ----------
    board : {"A", "B", "E"}
        The board, one commit each.

    Returns
    -------
    dict of str to ndarray of shape (n_samples,)
        Time in s, Q1 in %, T1 and T2 in °C.
    """
    table = sources.read_csv(
        sources.fetch("jckantor/TCLab", COMMITS[board], "notebooks/step_test_data.csv")
    )
    return {name: table[name] for name in ("Time", "Q1", "T1", "T2")}
