"""Rows on which the direction of motion is decided."""

import numpy as np
import pytest

import pysindy_evolve as pse
from pysindy_evolve.signals import is_decided

T = np.arange(0.0, 20.0, 0.01)


@pytest.mark.parametrize("order", [2, 3])
def test_rows_where_a_body_turns_are_left_out(order):
    record = pse.prepare(T, np.sin(T), cutoff=5.0, order=order)
    decided = is_decided(record)
    reach = 1.0 / 5.0 + 2.0 * record.dt
    turns = np.arange(0.5, 7.0) * np.pi
    near = np.min(np.abs(record.t[:, None] - turns), axis=1)
    assert np.all(near[~decided] <= reach)
    assert np.all(near[decided] >= reach - 4.0 * record.dt)


def test_rows_of_a_first_order_model_are_all_kept():
    assert is_decided(pse.prepare(T, np.sin(T), cutoff=5.0, order=1)).all()


def test_a_body_that_turns_all_the_time_is_looked_at_whole():
    assert is_decided(pse.prepare(T, np.sin(20.0 * T), cutoff=8.0)).all()


def test_what_is_no_record_is_refused():
    with pytest.raises(TypeError, match="must be a Record"):
        is_decided(np.zeros(5))
