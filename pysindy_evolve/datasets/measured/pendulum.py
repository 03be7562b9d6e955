"""Pendulum in free swing."""

from __future__ import annotations

import numpy as np

from .. import sources
from .record import Folder, MeasuredRecord, MeasuredSet


def load_pendulum(folder: Folder = None) -> MeasuredSet:
    """Single pendulum in free swing, its cart clamped, 1 kHz.

    Parameters
    ----------
    folder : path, optional
        Folder that holds ``pendulum_multiarm/single.npz``; searched for, or downloaded, by default.

    Returns
    -------
    MeasuredSet
        One record, cut: train ``"first"`` 60 %, test ``"rest"``. y: angle theta in rad, pi hangs
        down, in steps of 1.57e-4 rad; no input; extras: the authors' filtered velocity omega_given
        in rad/s, which lags.

    Raises
    ------
    FileNotFoundError
        If `folder` is given and does not hold the file.
    ImportError
        If the file has to be downloaded and pooch is not installed.

    References
    ----------
    Kaheman et al., "The experimental multi-arm pendulum on a cart", arXiv 2205.06231.
    """
    columns = sources.read_columns("pendulum_multiarm/single.npz", folder, _published)
    cut = int(0.6 * columns["t"].size)

    def record(name: str, part: slice) -> MeasuredRecord:
        return MeasuredRecord(
            name=name,
            t=columns["t"][part],
            y=columns["theta"][part, None],
            outputs=("theta",),
            extras={"omega_given": columns["omega_given"][part]},
        )

    first, rest = record("first", slice(None, cut)), record("rest", slice(cut, None))
    return MeasuredSet(train=(first,), test=(rest,))


def _published() -> sources.Columns:
    """Angle over time, joined again from the six pieces that the authors cut.

    Returns
    -------
    dict of str to ndarray of shape (n_samples,)
        t in s, theta in rad, omega_given in rad/s.
    """
    variables = sources.read_mat(
        sources.fetch(
            "dynamicslab/MultiArm-Pendulum",
            "e99a7e13fe2adc8fc647321a156b6cb59a48a698",
            "ParameterEstimation/SinglePendulum/SinglePendulumDataForParameterEstimation.mat",
        )
    )
    times = [np.ravel(piece) for part in ("Time_id", "Time_vad") for piece in variables[part]]
    states = np.hstack([piece for part in ("Y_id", "Y_vad") for piece in variables[part]])
    return {"t": np.concatenate(times), "theta": states[0], "omega_given": states[1]}
