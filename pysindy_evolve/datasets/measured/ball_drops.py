"""Balls dropped from a bridge."""

from __future__ import annotations

import numpy as np

from .. import sources
from .record import Folder, MeasuredRecord, MeasuredSet


def load_ball_drops(folder: Folder = None) -> MeasuredSet:
    """Eleven balls dropped twice from a bridge, filmed at 15 Hz.

    Parameters
    ----------
    folder : path, optional
        Folder that holds ``ball_drops/ball_drops.csv`` and ``ball_drops/balls.csv``; searched for
        by default. The public source is a spreadsheet, which is not downloaded.

    Returns
    -------
    MeasuredSet
        Train: the first drop of each ball, test: the second, named ``"Golf Ball, drop 1"``. y:
        height h in m, in steps of about 0.028 m; no input; extras: the authors' velocity v_given
        in m/s; constants: mass in kg, circumference in m (not known for the volleyball). The last
        time step can be irregular.

    Raises
    ------
    FileNotFoundError
        If no folder holds the files.

    References
    ----------
    de Silva, Higdon, Brunton, Kutz, "Discovery of physics from data", Frontiers in Artificial
    Intelligence 3:25, 2020, doi:10.3389/frai.2020.00025.
    """
    columns = sources.read_columns("ball_drops/ball_drops.csv", folder)
    balls = sources.read_columns("ball_drops/balls.csv", folder)

    known = {
        str(name): {"mass": float(mass), "circumference": float(circumference)}
        for name, mass, circumference in zip(
            balls["ball"], balls["mass_kg"], balls["circumference_m"], strict=True
        )
    }

    def record(name: str, drop: int) -> MeasuredRecord:
        rows = (columns["ball"] == name) & (columns["drop"] == drop)
        return MeasuredRecord(
            name=f"{name}, drop {drop}",
            t=columns["t"][rows],
            y=columns["h"][rows, None],
            outputs=("h",),
            extras={"v_given": columns["v_given"][rows]},
            constants=known.get(name, {}),
        )

    names = [str(name) for name in np.unique(columns["ball"])]
    return MeasuredSet(
        train=tuple(record(name, 1) for name in names),
        test=tuple(record(name, 2) for name in names),
    )
