"""A driven oscillator, sampled every 0.01."""

import numpy as np
import pytest

from .closeness import DT


@pytest.fixture
def t():
    return np.arange(4000) * DT


@pytest.fixture
def rng():
    return np.random.default_rng(7)


@pytest.fixture
def driven(t):
    """Position, acceleration and force of q'' = -k q - c q' + F, in its steady state."""
    k, c = 30.0, 1.5
    q = np.zeros_like(t)
    a, force = np.zeros_like(t), np.zeros_like(t)
    for omega in (1.0, 4.3, 9.1, 17.0):
        wave = np.exp(1j * (omega * t + omega**2))
        response = 1.0 / (k - omega**2 + 1j * c * omega)
        q += (response * wave).real
        a += (-(omega**2) * response * wave).real
        force += wave.real
    return q, a, force, (k, c)
