"""The fit of a design: exact where the data are, and honest about how sure it is."""

import numpy as np
import pytest
from loop_systems import measured

import pysindy_evolve as pse
from pysindy_evolve.loop.fitting.fit import derivative_errors, fit
from pysindy_evolve.loop.given.sticking import weights_in_motion
from pysindy_evolve.signals import Windows

TRUE = np.array([40.0, 0.8, 1.0, 2.0])
DECLARED = {"q": "v", "v": "-k*q - c*v + b*F - f*sgn(v)"}
MACHINE = {"q": "v", "v": "-40*q - 0.8*v + F - 2*sgn(v)"}


def design():
    return pse.DeclaredModel(DECLARED, inputs=["F"]).design()


def rng():
    return np.random.default_rng(0)


def clean(n=1500, start=(0.3, 0.0)):
    """Exact states and derivatives."""
    t = 0.01 * np.arange(n)
    force = (8.0 * np.sin(3.1 * t) + 6.0 * np.cos(5.3 * t + 1.0))[:, None]
    equations = design().equations(TRUE)
    x = pse.simulate(equations, start, t, force)
    return pse.Record(t=t, x=x, x_dot=equations.evaluate(x, force, t), u=force)


def test_clean_data_give_the_true_coefficients():
    found = fit(design(), [clean()], rng())
    assert found.coef == pytest.approx(TRUE, rel=1e-5)
    assert found.intervals == pytest.approx(np.column_stack([TRUE, TRUE]), rel=1e-3)


def test_several_records_of_different_length_give_the_true_coefficients():
    found = fit(design(), [clean(900), clean(400, (-0.2, 1.0))], rng())
    assert found.coef == pytest.approx(TRUE, rel=1e-5)


@pytest.mark.parametrize("noise", [1e-3, 5e-3])
def test_noise_on_the_position_leaves_the_coefficients_close(noise):
    found = fit(design(), [measured(MACHINE, noise=noise)], rng())
    assert found.coef[:3] == pytest.approx(TRUE[:3], rel=0.02)
    assert found.coef[3] == pytest.approx(TRUE[3], rel=0.15)


def test_noise_of_the_derivative_that_its_integral_does_not_have_leaves_the_fit_close():
    record = clean()
    position_noise = 0.02 * np.random.default_rng(0).standard_normal((len(record) + 1, 1))
    x_dot = record.x_dot + [0.0, 1.0] * np.diff(position_noise, axis=0) / record.dt
    noisy = pse.Record(t=record.t, x=record.x, x_dot=x_dot, u=record.u)
    found = fit(design(), [noisy], rng())
    assert found.criterion in {"derivative", "simulation"}
    assert found.coef[[0, 2]] == pytest.approx(TRUE[[0, 2]], rel=0.02)
    low, high = found.intervals.T
    assert np.all((low < found.coef) & (found.coef < high))


def test_intervals_hold_the_coefficients_and_shrink_with_more_data():
    def width(duration, seed):
        found = fit(design(), [measured(MACHINE, duration=duration, seed=seed)], rng())
        assert found.intervals.shape == (4, 2)
        low, high = found.intervals.T
        assert np.all(low < high)
        assert np.all((low <= found.coef) & (found.coef <= high))
        return high - low

    # By the square root of eight; how short a record excites a machine is chance.
    shrunk = [width(15.0, seed) / width(120.0, seed) for seed in range(5)]
    assert np.all(np.mean(shrunk, axis=0) > 1.5)


@pytest.mark.parametrize(("hits", "least", "most"), [((7, 17, 31), 0.02, 1.0), ((17,), 0.2, 15.0)])
def test_a_number_that_few_blocks_know_has_an_interval_around_it(hits, least, most):
    t = 0.01 * np.arange(4000)
    is_hit = np.min(np.abs(t - np.array(hits)[:, None]), axis=0) < 0.2
    q = np.where(is_hit, 0.8, 0.4 * np.sin(t))
    rate = -2.0 * q - 30.0 * np.maximum(q - 0.5, 0.0)
    noise = 0.05 * np.random.default_rng(0).standard_normal(len(t))
    record = pse.Record(t=t, x=q[:, None], x_dot=(rate + noise)[:, None])
    known = pse.DeclaredModel({"q": "-a*q - s*max(q - 0.5, 0)"}).design()
    found = fit(known, [record], rng(), "derivative")
    low, high = found.intervals[found.coef > 10.0][0]
    assert low < 30.0 < high
    assert least < high - low < most


@pytest.mark.parametrize("refine", ["derivative", "simulation"])
def test_error_to_minimize_can_be_chosen(refine):
    found = fit(design(), [measured(MACHINE, noise=1e-3, duration=15.0)], rng(), refine)
    assert found.criterion == refine
    assert found.coef[:3] == pytest.approx(TRUE[:3], rel=0.02)


def test_same_generator_gives_the_same_intervals():
    record = measured(MACHINE, duration=15.0)
    first, again = (fit(design(), [record], rng()) for _ in range(2))
    assert np.array_equal(first.coef, again.coef)
    assert np.array_equal(first.intervals, again.intervals)


def test_model_without_free_parameters_has_no_coefficients():
    known = pse.DeclaredModel({"q": "v", "v": "-40*q - 0.8*v + F"}, inputs=["F"]).design()
    found = fit(known, [clean()], rng())
    assert found.coef.shape == (0,)
    assert found.intervals.shape == (0, 2)


def test_parameter_shared_by_two_equations_is_fitted_to_both():
    t = 0.02 * np.arange(800)
    truth = pse.DeclaredModel({"a": "-0.5*a*b", "b": "0.5*a*b - 0.3*b"}).design().equations([])
    x = pse.simulate(truth, [1.0, 0.1], t)
    record = pse.Record(t=t, x=x, x_dot=truth.evaluate(x, None, t))
    shared = pse.DeclaredModel({"a": "-r*a*b", "b": "r*a*b - s*b"}).design()
    assert fit(shared, [record], rng()).coef == pytest.approx([0.5, 0.3], rel=1e-6)


def test_derivative_error_is_zero_for_the_truth_and_a_hundred_percent_for_nothing():
    record = clean()
    known = pse.DeclaredModel({"q": "v", "v": "0"}, inputs=["F"]).design()
    errors = derivative_errors(design(), TRUE, [record], Windows(1))
    assert errors == pytest.approx([0.0, 0.0], abs=1e-9)
    centered = record.x_dot - record.x_dot.mean(axis=0) * [0, 1]
    shifted = pse.Record(t=record.t, x=record.x, x_dot=centered, u=record.u)
    errors = derivative_errors(known, np.array([]), [shifted], Windows(1))
    # Rows at rest are left out, which takes a little from it.
    assert errors == pytest.approx([0.0, 100.0], abs=0.5)


def test_record_shorter_than_the_windows_is_judged_row_by_row():
    record = clean(60)
    errors = derivative_errors(design(), TRUE + np.array([0.5, 0, 0, 0]), [record], Windows(100))
    weight = weights_in_motion(record, design().velocities)[:, 1]
    rows = 0.5 * record.x[:, 0] * weight
    rms = np.sqrt(np.sum(rows**2) / np.sum(weight**2))
    expected = 100 * rms / record.x_dot[:, 1].std()
    assert errors == pytest.approx([0.0, expected], rel=1e-6)


@pytest.mark.slow
def test_intervals_cover_the_truth_in_about_95_percent():
    columns = pse.DeclaredModel({"q": "v", "v": "-k*q - c*v + b*F"}, inputs=["F"]).design()
    covered = []
    for seed in range(60):
        record = measured(
            {"q": "v", "v": "-40*q - 0.8*v + F"}, noise=5e-3, seed=seed, duration=20.0
        )
        low, high = fit(columns, [record], np.random.default_rng(seed)).intervals.T
        covered.append((low <= TRUE[:3]) & (high >= TRUE[:3]))
    share = np.mean(covered, axis=0)
    assert np.all(share > 0.85), share  # 60 draws at 95 % fall below this once in a thousand


def test_rows_in_which_the_model_has_no_value_are_not_judged():
    t = np.arange(0.0, 4.0, 0.01)
    h = (1.0 - 0.3 * t) * np.abs(1.0 - 0.3 * t)  # as sqrt(h) falls, and then below zero
    record = pse.Record(t=t, x=h, x_dot=-0.6 * np.sqrt(np.abs(h)))
    draining = pse.DeclaredModel({"h": "-a*sqrt(h)"}).design()
    assert derivative_errors(draining, np.array([0.6]), [record], Windows(1)) == pytest.approx(
        [0.0], abs=1e-9
    )
    below = pse.Record(t=t[350:], x=h[350:], x_dot=record.x_dot[350:])
    assert derivative_errors(draining, np.array([0.6]), [below], Windows(1)) == [np.inf]
