"""Cart under proportional control."""

from __future__ import annotations

import numpy as np

from .. import sources
from .record import Folder, MeasuredRecord, MeasuredSet


def load_cart(folder: Folder = None) -> MeasuredSet:
    """Cart under proportional position control at four gains, 1 kHz; no missing effect shows.

    Parameters
    ----------
    folder : path, optional
        Folder that holds ``cart_pcontrol/cart.npz``; searched for, or downloaded, by default.

    Returns
    -------
    MeasuredSet
        Gains ``"kP=2.5"``, ``"kP=5"`` and ``"kP=10"`` train, ``"kP=20"`` tests. y: position z in
        m; u: the control signal kP (0.2 m - z), which is zero until the control starts at 1 s.

    Raises
    ------
    FileNotFoundError
        If `folder` is given and does not hold the file.
    ImportError
        If the file has to be downloaded and pooch is not installed.

    References
    ----------
    Records of M. Kawata's book on inverted pendulums, https://github.com/Prof-Carter/book_ip.
    """
    columns = sources.read_columns("cart_pcontrol/cart.npz", folder, _published)

    def record(code: str) -> MeasuredRecord:
        gain = int(code) / 10
        t, z = columns[f"t_{code}"], columns[f"z_{code}"]
        return MeasuredRecord(
            name=f"kP={gain:g}",
            t=t,
            y=z[:, None],
            u=np.where(t >= 1.0, gain * (0.2 - z), 0.0)[:, None],
            outputs=("z",),
            inputs=("u",),
            constants={"kP": gain},
        )

    return MeasuredSet(
        train=tuple(record(code) for code in ("025", "050", "100")), test=(record("200"),)
    )


def _published() -> sources.Columns:
    """Cart position over time at each gain.

    Returns
    -------
    dict of str to ndarray of shape (n_samples,)
        t in s and z in m, each for the gains ``025``, ``050``, ``100`` and ``200``, in tenths.
    """
    columns: sources.Columns = {}
    for code in ("025", "050", "100", "200"):
        variables = sources.read_mat(
            sources.fetch(
                "Prof-Carter/book_ip",
                "7d5e476f404a7c83ac251f112998b723c586a05e",
                f"mfiles/p1c3/cdip_cart_pcont_data_kP_{code}_ref_02.mat",
            )
        )
        columns |= {f"t_{code}": np.ravel(variables["t"]), f"z_{code}": np.ravel(variables["z"])}
    return columns
