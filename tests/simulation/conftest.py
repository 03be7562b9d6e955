"""The friction rig, driven."""

import numpy as np
import pytest

from pysindy_evolve.simulation import simulate

from .sliding_systems import duffing


@pytest.fixture(scope="module")
def sweep():
    t = np.linspace(0.0, 2.0, 4001)
    return t, 9.0 * np.sin(2 * np.pi * (4.0 * t + t**2))


@pytest.fixture(scope="module")
def record():
    t = np.arange(6001) * 1e-3
    u = 9 * np.sin(2 * np.pi * (2 * t + 0.5 * t**2))
    return t, u, simulate(duffing(), [0.0, 0.0], t, u)
