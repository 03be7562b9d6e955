"""Magnetorheological damper."""

from __future__ import annotations

import numpy as np

from .. import sources
from .record import Folder, MeasuredRecord, MeasuredSet


def load_mr_damper(folder: Folder = None) -> MeasuredSet:
    """Magnetorheological damper on a shaking table, sinusoidal displacement, 100 Hz.

    Parameters
    ----------
    folder : path, optional
        Folder that holds ``mr_damper_labcontrol/mr_labcontrol.npz``; searched for by default. The
        public source does not name its columns and is not downloaded.

    Returns
    -------
    MeasuredSet
        Ten records ``"1"`` to ``"10"`` of decreasing amplitude: the odd ones train, the even ones
        test. y: force F in N, with the constant offset of the load cell (about 132 N); u:
        displacement x in mm.

    Raises
    ------
    FileNotFoundError
        If no folder holds the file.

    References
    ----------
    Labcontrol, UTFPR, Shaking table with MR damper, doi:10.5281/zenodo.4445334.
    """
    columns = sources.read_columns("mr_damper_labcontrol/mr_labcontrol.npz", folder)

    def record(number: int) -> MeasuredRecord:
        force = columns[f"F_{number}"]
        return MeasuredRecord(
            name=str(number),
            t=np.arange(force.size) / float(columns["fs"]),
            y=force[:, None],
            u=columns[f"x_{number}"][:, None],
            outputs=("F",),
            inputs=("x",),
        )

    return MeasuredSet(
        train=tuple(record(number) for number in range(1, 11, 2)),
        test=tuple(record(number) for number in range(2, 11, 2)),
    )
