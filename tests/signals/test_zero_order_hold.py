"""Inputs that are held from each sample to the next."""

import numpy as np
import pytest

import pysindy_evolve as pse
from pysindy_evolve.signals.zero_order_hold import HALF_SAMPLE, hold

T = np.arange(0.0, 20.0, 0.02)
U = np.column_stack([np.sin(2.0 * T), np.cos(T)])


def prepared(**options):
    return pse.prepare(T, np.sin(T), U, order=1, cutoff=4.0, decimate=1, **options)


def test_a_held_input_acts_half_a_sample_later():
    record = hold(prepared(), {0: HALF_SAMPLE})
    inside = slice(20, -20)
    assert record.u[inside, 0] == pytest.approx(np.sin(2.0 * (record.t - 0.01))[inside], abs=1e-4)
    assert record.u[inside, 1] == pytest.approx(np.cos(record.t)[inside], abs=1e-4)


def test_an_input_that_is_known_as_held_stays_as_it_is():
    record = hold(prepared(), {0: HALF_SAMPLE})
    assert hold(record, {0: HALF_SAMPLE}) is record
    both = hold(record, {0: 0.3, 1: 0.2})
    assert both.u[:, 0] == pytest.approx(record.u[:, 0])
    assert both.held == {0: HALF_SAMPLE, 1: 0.2}


@pytest.mark.parametrize(("held", "known"), [(True, {0, 1}), (False, set()), ([1], {1})])
def test_prepare_takes_inputs_as_held_where_it_is_told(held, known):
    record = prepared(held=held)
    assert set(record.held) == known
    assert record.u == pytest.approx(hold(prepared(), dict.fromkeys(known, HALF_SAMPLE)).u)
    assert set(record[100:200].held) == known


def test_a_record_that_was_made_elsewhere_is_held_at_its_own_samples():
    record = pse.Record(t=T, x=np.sin(T), x_dot=np.cos(T), u=U[:, 0])
    assert hold(record, {0: HALF_SAMPLE}).u[20:-20, 0] == pytest.approx(
        np.sin(2.0 * (T - 0.01))[20:-20], abs=1e-5
    )


@pytest.mark.parametrize(
    ("held", "error", "message"),
    [
        ("F", TypeError, "must be a bool or a sequence of int"),
        ([0.5], TypeError, "must be a bool or a sequence of int"),
        ([2], ValueError, "must be columns of u below 2"),
    ],
)
def test_what_is_held_must_be_columns_of_u(held, error, message):
    with pytest.raises(error, match=message):
        prepared(held=held)
