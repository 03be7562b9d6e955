"""Electro-mechanical positioning system."""

from __future__ import annotations

import numpy as np

from .. import sources
from .record import Folder, MeasuredRecord, MeasuredSet


def load_emps(folder: Folder = None) -> MeasuredSet:
    """Electro-mechanical positioning system: motor force to position of a linear axis, 1 kHz.

    Parameters
    ----------
    folder : path, optional
        Folder that holds ``emps/emps.npz``; searched for, or downloaded, by default.

    Returns
    -------
    MeasuredSet
        Train: ``"train"``; test: ``"pulses"``, with force pulses on the same trajectory. y:
        position q in m; u: motor force F in N; extras: reference qref in m, controller output
        u_V in V.

    Raises
    ------
    FileNotFoundError
        If `folder` is given and does not hold the file.
    ImportError
        If the file has to be downloaded and pooch is not installed.

    References
    ----------
    Janot, Gautier, Brunot, "Data set and reference models of EMPS", Nonlinear System
    Identification Benchmarks, 2019.
    """
    columns = sources.read_columns("emps/emps.npz", folder, _published)

    def record(name: str, part: str) -> MeasuredRecord:
        return MeasuredRecord(
            name=name,
            t=columns[f"{part}_t"],
            y=columns[f"{part}_q"][:, None],
            u=columns[f"{part}_force"][:, None],
            outputs=("q",),
            inputs=("F",),
            extras={"qref": columns[f"{part}_qref"], "u_V": columns[f"{part}_u_V"]},
        )

    return MeasuredSet(train=(record("train", "train"),), test=(record("pulses", "test"),))


def _published() -> sources.Columns:
    """Position and force of both records, from the authors' MATLAB files.

    Returns
    -------
    dict of str to ndarray of shape (n_samples,)
        t in s, q and qref in m, u_V in V, force in N, each for ``train`` and ``test``.
    """
    columns: sources.Columns = {}
    for part, name in (("train", "DATA_EMPS"), ("test", "DATA_EMPS_PULSES")):
        variables = sources.read_mat(
            sources.fetch(
                "forgi86/sysid-neural-continuous",
                "956aa7ecd73061b0321c6f6098d74c9e4a7ce67a",
                f"examples/EMPS/data/{name}.mat",
            )
        )
        voltage = np.ravel(variables["vir"])
        columns |= {
            f"{part}_t": np.ravel(variables["t"]),
            f"{part}_q": np.ravel(variables["qm"]),
            f"{part}_qref": np.ravel(variables["qg"]),
            f"{part}_u_V": voltage,
            f"{part}_force": float(variables["gtau"]) * voltage,
        }
    return columns
