"""ODEBench: 63 systems of ordinary differential equations from textbooks."""

import json
import os
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from .sources import ENVIRONMENT_VARIABLE, locate


@dataclass(frozen=True, eq=False)
class OdeSystem:
    """One system of ODEBench.

    Parameters
    ----------
    number : int
        Its number, from 1 to 63.
    name : str
        What it models.
    equations : tuple of str
        Right-hand sides in the states x_0, x_1, …, with numbers for the constants.
    constants : mapping of str to float
        The constants.
    initial_states : ndarray of shape (2, n_states)
        Two initial states: one to fit from, one to judge from.
    t_span : tuple of float
        First and last time.
    """

    number: int
    name: str
    equations: tuple[str, ...]
    constants: Mapping[str, float]
    initial_states: np.ndarray
    t_span: tuple[float, float]


def load_odebench(folder: str | os.PathLike[str] | None = None) -> tuple[OdeSystem, ...]:
    """Sixty-three systems of one to four states, as equations without measurements.

    Integrate them yourself, at a tight tolerance: the trajectories of the public source are wrong
    for the chaotic systems.

    Parameters
    ----------
    folder : path, optional
        Folder that holds ``odebench/odebench.json``; searched for by default. The public source has
        another format and is not downloaded.

    Returns
    -------
    tuple of OdeSystem
        The systems in their order.

    Raises
    ------
    FileNotFoundError
        If no folder holds the file.

    References
    ----------
    d'Ascoli, Becker, Mathis, Schwaller, Kilbertus, "ODEFormer", arXiv 2310.05573.
    """
    file = "odebench/odebench.json"
    path = locate(file, folder)
    if path is None:
        raise FileNotFoundError(
            f"load_odebench(folder=...) must name a folder that holds {file}; got None, and "
            f"neither {ENVIRONMENT_VARIABLE} nor ../shared/data has it. Pass the folder."
        )
    systems = json.loads(path.read_text(encoding="utf-8"))["systems"]
    return tuple(
        OdeSystem(
            number=system["id"],
            name=system["name"],
            equations=tuple(system["substituted"]),
            constants=system["consts"],
            initial_states=np.array(system["inits"], dtype=float),
            t_span=(float(system["t_span"][0]), float(system["t_span"][1])),
        )
        for system in systems
    )
