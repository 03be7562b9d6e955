"""Errors of free runs and windows."""

import numpy as np
import pytest

from pysindy_evolve.simulation import simulate

from .sliding_systems import block


class TestErrors:
    t = np.linspace(0.0, 1.0, 11)
