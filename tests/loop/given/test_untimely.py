"""Jumps between two samples: what an input may differ by from its record."""

import numpy as np
import pytest

import pysindy_evolve as pse
from pysindy_evolve.loop.given.input_errors import untimely


@pytest.fixture
def record():
    """A first-order state with an input that steps, the same one again, and one that runs on."""
    rng = np.random.default_rng(0)
    t = 0.01 * np.arange(2000)
    steps = np.repeat(rng.uniform(-1.0, 1.0, 20), 100)
    u = np.column_stack([steps, steps, np.sin(t)])
    return pse.prepare(t, np.cumsum(steps) * 0.01, u, order=1)


def test_only_inputs_that_are_asked_for_and_jump_may_have_jumped_earlier(record):
    error = untimely(record, [0, 2])
    assert error.shape == record.u.shape
    assert np.abs(error[:, 0]).max() > 0.01
    assert not error[:, 1:].any()


def test_all_inputs_jump_at_once(record):
    error = untimely(record, [0, 1], np.random.default_rng(1))
    np.testing.assert_allclose(error[:, 0], error[:, 1])


def test_an_input_that_runs_on_has_no_jumps(record):
    assert untimely(record, [2]) is None
    assert untimely(record, []) is None
