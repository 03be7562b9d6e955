"""Jumps between two samples: what an input may differ by from its record."""

import numpy as np
import pytest

import pysindy_evolve as pse
from pysindy_evolve.loop.given.input_errors import jump_time_error, may_be_steps


@pytest.fixture
def record():
    """A first-order state with an input that steps, the same one again, and one that runs on."""
    rng = np.random.default_rng(0)
    t = 0.01 * np.arange(2000)
    steps = np.repeat(rng.uniform(-1.0, 1.0, 20), 100)
    u = np.column_stack([steps, steps, np.sin(t)])
    return pse.prepare(t, np.cumsum(steps) * 0.01, u, order=1)


def test_only_inputs_that_are_asked_for_and_jump_may_have_jumped_earlier(record):
    error = jump_time_error(record, [0, 2])
    assert error.shape == record.u.shape
    assert np.abs(error[:, 0]).max() > 0.01
    assert not error[:, 1:].any()


def test_all_inputs_jump_at_once(record):
    error = jump_time_error(record, [0, 1], np.random.default_rng(1))
    np.testing.assert_allclose(error[:, 0], error[:, 1])


def test_an_input_that_runs_on_has_no_jumps(record):
    assert jump_time_error(record, [2]) is None
    assert jump_time_error(record, []) is None


def test_only_steps_that_tell_little_of_the_next_may_be_those_of_a_hold():
    rng, t = np.random.default_rng(0), np.arange(3000)
    jitter, jumps = rng.standard_normal(3000), np.repeat(rng.standard_normal(100), 30)
    means = 0.5 * (jumps + np.r_[jumps[:1], jumps[:-1]])
    smooth = np.sin(0.02 * t)
    assert may_be_steps(jumps)
    assert may_be_steps(5.0 * smooth + 0.1 * jitter)  # a controller that answers noise
    assert not may_be_steps(smooth)
    assert not may_be_steps(means)  # about each sample: known as well as they can be
