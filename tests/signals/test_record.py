"""Records: validated, sliced and split alike, immutable."""

import numpy as np
import pytest

from pysindy_evolve.signals import Record, prepare


def test_record_promotes_one_dimension_to_a_column():
    record = Record(t=[0, 1, 2], x=[1, 2, 3], x_dot=[1, 1, 1], u=[0, 0, 1])
    assert record.x.shape == record.x_dot.shape == record.u.shape == (3, 1)
    assert (record.n_samples, record.n_states, record.n_inputs, record.dt) == (3, 1, 1, 1.0)
    assert len(record) == 3


def test_record_leaves_its_inputs_alone():
    t, x = np.arange(5.0), np.arange(5)
    before = x.copy()
    Record(t=t, x=x, x_dot=x)
    np.testing.assert_array_equal(x, before)
    assert x.dtype == before.dtype


def test_record_slices_every_column_alike(t):
    record = Record(t=t, x=np.sin(t), x_dot=np.cos(t), u=t, states=("q",), inputs=("F",))
    part = record[100:200]
    np.testing.assert_array_equal(part.t, t[100:200])
    np.testing.assert_array_equal(part.u[:, 0], t[100:200])
    assert (part.states, part.inputs) == (("q",), ("F",))


def test_split_holds_out_the_last_part(t):
    record = Record(t=t, x=t, x_dot=t)
    first, last = record.split(0.25)
    assert (first.n_samples, last.n_samples) == (3000, 1000)
    assert first.t[-1] < last.t[0]


def test_other_inputs_pass_the_low_pass_as_the_old_ones_did(t, rng):
    force = np.cos(t) + 0.1 * rng.standard_normal(t.size)
    record = prepare(t, np.sin(t), force, cutoff=4.0)
    doubled = record.with_inputs(lambda _, u: 2.0 * u)
    np.testing.assert_array_equal(doubled.raw_u[:, 0], 2.0 * force)
    np.testing.assert_allclose(doubled.u, 2.0 * record.u, atol=1e-12)
    np.testing.assert_array_equal(record.lowpass(doubled.raw_u), doubled.u)
    assert (record.cutoff, record.raw_dt) == (4.0, record.preparation.dt)
    assert record.has_raw_inputs


def test_a_record_without_raw_data_stands_for_them(t):
    record = Record(t=t, x=t, x_dot=t, u=t)
    later = record.with_inputs(lambda times, u: u + times[:, None])
    np.testing.assert_array_equal(later.raw_u, 2.0 * record.u)
    assert (later.cutoff, later.raw_dt, later.has_raw_inputs) == (None, record.dt, False)
    alone = Record(t=t, x=t, x_dot=t)
    assert alone.with_inputs(lambda _, u: u) is alone
    assert alone.raw_u.shape == (len(t), 0)


def test_record_cannot_be_changed(t):
    record = Record(t=t, x=t, x_dot=t)
    with pytest.raises(AttributeError, match="cannot assign"):
        record.x = t


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"x": [1.0, np.nan, 3.0]}, r"Record\(x=...\) must be finite; got nan at sample 1"),
        ({"x_dot": [[1.0], [2.0], [np.inf]]}, r"Record\(x_dot=...\).* inf at sample 2, column 0"),
        ({"x": [1.0, 2.0]}, r"Record\(x=...\) must be as long as t; got 2 samples, t has 3"),
        ({"u": [1.0]}, r"Record\(u=...\) must be as long as t"),
        ({"t": [0.0, 2.0, 1.0]}, r"strictly increasing; got a step of -1 at sample 2"),
        ({"t": [0.0, 1.0, 1.0]}, r"strictly increasing; got a step of 0 at sample 2"),
        ({"t": np.zeros((3, 2))}, r"Record\(t=...\) must be 1-D"),
        ({"x": np.zeros((3, 2))}, r"Record\(x_dot=...\) must be of the shape of x"),
        ({"x": np.zeros((3, 1, 1))}, r"Record\(x=...\) must be 1-D or 2-D"),
        ({"x": np.zeros((3, 0))}, r"Record\(x=...\) must be 1-D or 2-D"),
        ({"x": [[1.0], [2.0, 3.0], [4.0]]}, r"Record\(x=...\) must be a rectangular array"),
        ({"x": [1e60, 2.0, 3.0]}, r"Record\(x=...\) must be at most 1e\+50 in size"),
        ({"t": [0.0, 1e-30, 2e-30]}, r"Record\(t=...\) must be in steps of 1e-20 to 1e\+20"),
        ({"states": ("a", "b")}, r"Record\(states=...\) must be 1 distinct names"),
        ({"inputs": ("F",)}, r"Record\(inputs=...\) must be 0 distinct names"),
    ],
)
def test_record_refuses_bad_values(change, message):
    good = {"t": [0.0, 1.0, 2.0], "x": [1.0, 2.0, 3.0], "x_dot": [1.0, 1.0, 1.0]}
    with pytest.raises(ValueError, match=message):
        Record(**{**good, **change})


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"x": ["a", "b", "c"]}, r"Record\(x=...\) must be real numbers"),
        ({"x": [1j, 2, 3]}, r"Record\(x=...\) must be real numbers"),
        ({"x": [None, 2, 3]}, r"Record\(x=...\) must be real numbers"),
        ({"states": "q"}, r"Record\(states=...\) must be a sequence of str"),
        ({"states": 3}, r"Record\(states=...\) must be a sequence of str"),
    ],
)
def test_record_refuses_bad_types(change, message):
    good = {"t": [0.0, 1.0, 2.0], "x": [1.0, 2.0, 3.0], "x_dot": [1.0, 1.0, 1.0]}
    with pytest.raises(TypeError, match=message):
        Record(**{**good, **change})


def test_record_refuses_odd_slices_and_splits(t):
    record = Record(t=t, x=t, x_dot=t)
    with pytest.raises(TypeError, match=r"rows=...\) must be a slice; got int"):
        record[3]
    with pytest.raises(ValueError, match="slice with step 1; got 2"):
        record[::2]
    with pytest.raises(ValueError, match="at least 2 samples long; got 0"):
        record[5:5]
    with pytest.raises(ValueError, match=r"fraction=...\) must be between 0 and 1; got 1.0"):
        record.split(1.0)
    with pytest.raises(ValueError, match="both parts keep 2 samples"):
        record[:5].split(0.1)
