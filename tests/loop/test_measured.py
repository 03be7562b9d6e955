"""Measured records must give what the table of the benchmark demands, all with the defaults.

The cases, their splits and the bounds stand in benchmarks/measured.py, so that what is printed
there is what holds here.
"""

import importlib

import pytest

NAMES = (
    "emps",
    "pendulum",
    "silverbox",
    "tclab",
    "cascaded_tanks",
    "cart without kP=2.5",
    "cart without kP=5",
    "cart without kP=10",
    "cart without kP=20",
    "ball_drops Golf Ball",
    "ball_drops Bowling Ball",
)

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def benchmark(repository):
    """The module of the benchmark, importable by its own processes too."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(repository / "benchmarks")
        yield importlib.import_module("measured")


@pytest.fixture(scope="module", params=NAMES)
def measured(request, benchmark, data_dir):
    """Name of a case and what came out of it, in a process of its own."""
    return request.param, benchmark.in_new_process(request.param, data_dir)


def test_every_case_of_the_benchmark_is_tested(benchmark):
    assert set(benchmark.CASES) == set(NAMES)


def test_the_effects_that_the_machine_has_are_named(measured):
    _, result = measured
    assert result.reached["names"], result.text


def test_derivative_error_stays_below_its_bound(measured):
    _, result = measured
    assert result.reached["derivative"], result.text


def test_free_runs_stay_below_their_bounds(measured):
    _, result = measured
    assert result.reached["free run"], result.text


def test_free_runs_of_a_corrected_model_beat_the_declared_ones(measured):
    _, result = measured
    for before, after, _ in result.runs:
        assert after < before or not result.effects, result.text


def test_memory_stays_below_a_gigabyte(measured):
    _, result = measured
    assert result.megabytes < 1000.0
