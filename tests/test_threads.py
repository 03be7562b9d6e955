"""The linear algebra runs on one thread inside, and as before outside."""

import numpy as np
import pytest
from threadpoolctl import threadpool_info, threadpool_limits

from pysindy_evolve.threads import one_thread


def n_threads():
    blas = [library for library in threadpool_info() if library["user_api"] == "blas"]
    return max(library["num_threads"] for library in blas)


@pytest.fixture
def two_threads():
    np.ones((2, 2)) @ np.ones((2, 2))
    with threadpool_limits(limits=2):
        if n_threads() < 2:
            pytest.skip("the libraries here have one thread only")
        yield


def test_there_is_one_thread_inside_and_as_many_as_before_outside(two_threads):
    with one_thread():
        assert n_threads() == 1
        with one_thread():
            assert n_threads() == 1
        assert n_threads() == 1
    assert n_threads() == 2


def test_an_error_inside_restores_the_threads(two_threads):
    with pytest.raises(ValueError, match="inside"), one_thread():
        raise ValueError("inside")
    assert n_threads() == 2
