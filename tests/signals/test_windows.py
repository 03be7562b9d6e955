"""Windows: averages and derivatives by parts, within one trajectory."""

import time

import numpy as np
import pytest

from pysindy_evolve.signals import (
    Record,
    Windows,
    choose_windows,
    prepare,
    project,
    project_derivative,
)

from .closeness import DT, nrmse


@pytest.fixture
def windows():
    return Windows(width=20, stride=5)


def test_projection_is_the_weighted_mean_over_each_window(rng, windows):
    columns = rng.standard_normal((103, 3))
    found = project(columns, windows)
    assert found.shape == (windows.count(103), 3) == (17, 3)
    slow = [windows.weights @ columns[5 * i : 5 * i + 20] for i in range(17)]
    np.testing.assert_allclose(found, slow)
    np.testing.assert_allclose(project(columns[:, 0], windows), found[:, 0])
    np.testing.assert_allclose(project(np.arange(103.0), windows), windows.centers(103))


def test_projected_derivative_is_that_of_the_signal(t):
    windows = Windows(width=40, stride=10)
    x, x_dot = np.sin(2 * t), 2 * np.cos(2 * t)
    by_parts = project_derivative(x, windows, DT)
    np.testing.assert_allclose(by_parts, project(x_dot, windows), atol=2e-5)
    np.testing.assert_allclose(project_derivative(5 * t + 3, windows, DT), 5.0)


def test_projected_derivative_sees_through_noise_that_drowns_differences(t, rng):
    windows = Windows(width=200, stride=50)
    x = np.sin(2 * t) + 0.01 * rng.standard_normal(t.size)
    error = project_derivative(x, windows, DT) - project(2 * np.cos(2 * t), windows)
    assert np.std(error) < 0.01
    assert np.std(np.gradient(x, DT) - 2 * np.cos(2 * t)) > 0.5


def test_no_window_crosses_from_one_trajectory_to_the_next(rng, windows):
    first, second = rng.standard_normal((50, 2)), rng.standard_normal((37, 2))
    together = project(np.concatenate([first, second]), windows, lengths=[50, 37])
    apart = np.concatenate([project(first, windows), project(second, windows)])
    np.testing.assert_array_equal(together, apart)


def test_projection_is_fast(rng):
    columns = rng.standard_normal((250_000, 40))
    start = time.process_time()
    project(columns, Windows(width=24, stride=6))
    assert time.process_time() - start < 1.0


def test_windows_of_one_sample_leave_the_rows_alone(rng):
    columns = rng.standard_normal((10, 2))
    same = project(columns, Windows(width=1))
    np.testing.assert_array_equal(same, columns)
    assert same is not columns


def test_chosen_windows_average_noise_and_keep_the_signal(t, rng, driven):
    q, a, force, (k, c) = driven
    record = prepare(t, q + 2e-3 * q.std() * rng.standard_normal(t.size), force)
    windows = choose_windows(record)
    terms = np.column_stack([record.x, record.u])
    true = np.array([-k, -c, 1.0])

    def misfit(w):
        target = project(record.x_dot[:, 1], w)
        return nrmse(project(terms, w) @ true, target)

    assert windows.width > 4
    assert misfit(windows) < 0.7 * misfit(Windows(1))
    kept = project(record.x_dot[:, 1], windows)
    assert kept.std() > 0.7 * a.std()


def test_windows_can_be_chosen_for_records_without_preparation(t, rng):
    noisy = np.cos(t) + 0.05 * rng.standard_normal(t.size)
    records = [Record(t=t, x=np.sin(t), x_dot=noisy), Record(t=t, x=np.sin(t), x_dot=noisy)]
    assert 20 < choose_windows(records).width < 400
    still = Record(t=t, x=t, x_dot=np.ones_like(t))
    assert choose_windows(still) == Windows(1)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda w: Windows(width=0), r"Windows\(width=...\) must be an integer of at least 1"),
        (lambda w: project(np.ones(10), w), r"windows=...\) must be narrower than a trajectory"),
        (lambda w: project(np.ones(50), w, [20, 20]), r"lengths=...\) must be the samples of"),
        (lambda w: project(np.ones(50), w, [45, 5]), r"windows=...\) must be narrower than a"),
        (lambda w: project(np.ones(50) * np.nan, w), r"project\(columns=...\) must be finite"),
        (lambda w: project_derivative(np.ones(50), Windows(1), 1.0), "2 samples wide or more"),
        (lambda w: choose_windows([]), r"choose_windows\(records=...\) must be one record or more"),
    ],
)
def test_windows_refuse_bad_values(windows, call, message):
    with pytest.raises(ValueError, match=message):
        call(windows)


def test_means_of_terms_may_be_larger_than_a_signal_may(windows):
    np.testing.assert_allclose(project(np.full(50, 1e80), windows), 1e80)


def test_windows_refuse_bad_types(windows):
    with pytest.raises(TypeError, match=r"Windows\(width=...\) must be an integer.*; got float"):
        Windows(width=2.5)
    with pytest.raises(TypeError, match=r"project\(windows=...\) must be Windows; got int"):
        project(np.ones(50), 5)
    with pytest.raises(TypeError, match=r"choose_windows\(records=...\) must be a Record"):
        choose_windows([1, 2])
