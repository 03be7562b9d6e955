"""Measured records must give what the table of the benchmark demands, all with the defaults.

The cases, their splits and the bounds stand in benchmarks/measured.py, so that what is printed
there is what holds here.
"""

import importlib.util
import sys

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
    path = repository / "benchmarks" / "measured.py"
    spec = importlib.util.spec_from_file_location("benchmark_measured", path)
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # dataclasses look their module up
    spec.loader.exec_module(module)
    yield module
    del sys.modules[spec.name]


@pytest.fixture(scope="module", params=NAMES)
def measured(request, benchmark, data_dir):
    """Name of a case and what came out of it."""
    return request.param, benchmark.measure(request.param, data_dir)


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


def test_free_runs_of_a_corrected_model_beat_the_declared_ones(measured, request):
    name, result = measured
    if name == "tclab":  # judged on another board, with a heater of its own
        reason = "T2 of the other board: 1.54 C, declared 1.49 C"
        request.applymarker(pytest.mark.xfail(reason=reason, strict=True))
    for before, after, _ in result.runs:
        assert after < before or not result.effects, result.text


def test_memory_stays_below_a_gigabyte(data_dir, repository):
    """In a process of its own, as the peak of a process never sinks."""
    import subprocess

    done = subprocess.run(
        [sys.executable, "benchmarks/measured.py", "emps", "--folder", str(data_dir)],
        cwd=repository,
        capture_output=True,
        text=True,
        check=True,
    )
    cells = [cell.strip() for cell in done.stdout.splitlines()[-1].strip("| ").split("|")]
    assert cells[0] == "emps"
    assert float(cells[-1].removesuffix(" MB")) < 1000.0
