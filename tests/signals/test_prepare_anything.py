"""Any input at all ends in a record or in an error that says what to do."""

import warnings

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from pysindy_evolve.signals import (
    choose_windows,
    prepare,
    project,
)

anything = st.one_of(
    st.none(),
    st.text(max_size=3),
    st.integers(-3, 200),
    st.floats(allow_nan=True, allow_infinity=True),
    st.lists(st.integers(0, 3), max_size=3),
)
arrays = hnp.arrays(
    dtype=st.sampled_from([np.float64, np.float32, np.int64, np.bool_]),
    shape=st.tuples(st.integers(0, 60)) | st.tuples(st.integers(20, 60), st.integers(0, 3)),
)
times = st.builds(
    lambda n, dt, jitter: dt * (np.arange(n) + jitter * np.sin(np.arange(n) ** 2)),
    st.integers(0, 60),
    st.floats(1e-25, 1e25),
    st.sampled_from([0.0, 0.001, 0.1, 0.6]),
)


@settings(max_examples=300, deadline=None)
@given(
    t=times | anything,
    y=arrays | anything,
    u=arrays | st.none() | anything,
    order=st.integers(1, 3) | anything,
    cutoff=st.just("auto") | anything,
    decimate=st.just("auto") | anything,
    method=st.sampled_from(["fft", "savgol", "central"]),
)
def test_any_input_ends_in_a_record_or_a_house_error(t, y, u, order, cutoff, decimate, method):
    if isinstance(t, np.ndarray) and isinstance(y, np.ndarray):
        t = t[: len(y)]
        y = y[: len(t)]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            record = prepare(t, y, u, order, cutoff, decimate, method)
        except (ValueError, TypeError) as error:
            message = str(error)
        else:
            message = "must be"
            project(record.x_dot, choose_windows(record))
    assert "must be" in message


@settings(max_examples=200, deadline=None)
@given(
    y=hnp.arrays(
        np.float64,
        st.tuples(st.integers(30, 80), st.integers(1, 2)),
        elements=st.floats(-1e50, 1e50),
    ),
    dt=st.floats(1e-19, 1e19),
    order=st.integers(1, 8),
    method=st.sampled_from(["fft", "savgol", "central"]),
)
def test_any_finite_record_is_prepared_or_refused(y, dt, order, method):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            record = prepare(dt * np.arange(len(y)), y, order=order, method=method)
        except ValueError as error:
            message = str(error)
        else:
            message = "must be"
            project(record.x_dot, choose_windows(record))
    assert "must be" in message
