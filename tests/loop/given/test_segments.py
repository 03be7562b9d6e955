"""Pieces of records know the records that they were cut from."""

import numpy as np
import pytest
from loop_systems import measured

from pysindy_evolve.hidden_states.memory import with_past_inputs
from pysindy_evolve.loop.given.segments import segments


@pytest.fixture
def record():
    return measured({"q": "v", "v": "-60*q - 0.8*v + F"})


def test_some_of_the_pieces_keep_all_records(record):
    part = segments([record[:2000], record[2000:]], (1,))
    assert [len(one) for one in part.every_other(0).records] == [2000, len(record) - 2000]
    assert part.after([100, 100]).records is part.records


def test_the_same_pieces_of_other_records_hold_those(record):
    part = segments([record[:2000]], (1,)).tracked()
    again = part.of([record[1000:3000]])
    assert again.by_trajectory
    assert np.array_equal(again.records[0].x, record[1000:3000].x)
    assert again.band.records is again.records


def test_records_that_began_otherwise_have_the_same_rows(record):
    part = segments([record], (1,))
    elsewhere = with_past_inputs(record, [7.0])
    moved = part.with_pasts_of([elsewhere])
    assert moved.records == (elsewhere,)
    assert moved.band.records is moved.records
    assert moved.z is part.z
    assert moved.weight is part.weight
