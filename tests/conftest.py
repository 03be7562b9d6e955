"""Fixtures that more than one test module uses."""

import os
from pathlib import Path

import numpy as np
import pytest
from hypothesis import settings
from loop_systems import measured, oscillator

import pysindy_evolve as pse

# A developer explores new inputs at each run; CI repeats the same ones, so it judges the change.
settings.register_profile("ci", derandomize=True)
if os.environ.get("CI", "").lower() == "true":
    settings.load_profile("ci")

REPOSITORY = Path(__file__).resolve().parents[1]


@pytest.fixture(scope="session")
def data_dir() -> Path:
    """Folder of the measured records; without it a test is skipped, or fails on CI."""
    folder = Path(os.environ.get("PYSINDY_EVOLVE_DATA", REPOSITORY.parent / "shared" / "data"))
    if folder.is_dir():
        return folder
    reason = f"no measured records at {folder}; set PYSINDY_EVOLVE_DATA to their folder"
    if os.environ.get("CI", "").lower() == "true":
        pytest.fail(reason)
    pytest.skip(reason)


@pytest.fixture(scope="session")
def report() -> pse.LoopReport:
    """A loop that finds friction and an offset."""
    hidden = oscillator("friction and offset", "- 2*sgn(v) + 1.5")
    return pse.close_loop(hidden.model, hidden.record(), operators=(), random_state=0)


@pytest.fixture(scope="session")
def complete() -> pse.LoopReport:
    """A loop on a machine whose model lacks nothing."""
    record = measured({"q": "v", "v": "-40*q - 0.8*v + F"}, duration=25.0)
    declared = pse.DeclaredModel({"q": "v", "v": "-k*q - c*v + b*F"}, inputs=["F"])
    return pse.close_loop(declared, record, operators=(), random_state=0)


@pytest.fixture(scope="session")
def repository() -> Path:
    """Root of the source tree, which holds the README."""
    return REPOSITORY


@pytest.fixture
def sparse_problem():
    """Twelve columns of very different sizes, three of them true: theta, coef and y."""
    rng = np.random.default_rng(0)
    theta = rng.normal(size=(600, 12)) * 10.0 ** rng.integers(-6, 6, 12)
    coef = np.zeros(12)
    coef[[1, 5, 9]] = [2.0, -1.0, 0.5] / np.std(theta[:, [1, 5, 9]], axis=0)
    return theta, coef, theta @ coef + 0.1 * rng.normal(size=600)
