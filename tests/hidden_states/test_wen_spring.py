"""Hysteresis of a spring: the path operator, its hidden state, and how it is found."""

import numpy as np
import pytest
import sympy
from scipy.integrate import solve_ivp

import pysindy_evolve as pse
from pysindy_evolve.hidden_states.boucwen import yielding_along
from pysindy_evolve.hidden_states.path_states import kind_of, path_rates, paths_in
from pysindy_evolve.hidden_states.wen_spring import springing, springing_along
from pysindy_evolve.terms import variable

DECLARED = pse.DeclaredModel({"q": "v", "v": "F - c*v - k*q"}, inputs=["F"])
(PATH,) = (atom for atom, _ in springing(variable(0), variable(1), 0.7, 0.4).parts[0][1].factors)


def swing(t):
    """Position from zero, and velocity."""
    x = np.sin(t) + 0.6 * np.sin(2.3 * t + 1.0) - 0.6 * np.sin(1.0)
    return x, np.cos(t) + 1.38 * np.cos(2.3 * t + 1.0)


@pytest.mark.parametrize(("length", "loss"), [(0.7, 0.4), (0.3, 0.5), (1.0, 0.9), (0.9, 0.05)])
def test_path_operator_solves_the_differential_equation(length, loss):
    def rate(t, w):
        v = swing(t)[1]
        return (v - loss * abs(v) * w - (loss - 1.0) * v * abs(w)) / length

    t = np.arange(0.0, 20.0, 0.001)
    exact = solve_ivp(rate, (0.0, t[-1]), [0.0], t_eval=t, rtol=1e-9, atol=1e-10, max_step=0.01)
    along = springing_along(swing(t)[0], length, loss)
    assert along == pytest.approx(exact.y[0], abs=1e-4 * np.abs(exact.y).max())


def test_dahls_friction_is_the_same_in_both_forms():
    x = swing(np.arange(0.0, 20.0, 0.01))[0]
    assert springing_along(x, 0.3, 1.0) == pytest.approx(yielding_along(x, 0.3, 1.0))


def test_rate_of_the_hidden_state_is_what_its_docstring_says():
    w, v = 1.3, -2.0
    rows = np.array([[0.0, v, w]])
    expected = (v - 0.4 * abs(v) * w + 0.6 * v * abs(w)) / 0.7
    (rate,) = path_rates(PATH, [variable(2)])
    assert rate.evaluate(rows) == pytest.approx([expected])


def test_numbers_come_back_from_their_weights_within_limits():
    kind = kind_of(PATH)
    assert kind.numbers_from(np.array(kind.weights(PATH))) == pytest.approx([0.7, 0.4])
    assert kind.numbers_from(np.array([2.0, 9.0])) == pytest.approx([0.5, 1.0])


def mount(loss, bend, seed, noise=2e-3, late=0.0):
    """Measure a mass on a mount whose spring forgets; z' = v - loss |v| z - bend v |z|.

    The force acts late by so much time.
    """
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, 25.0, 0.01)
    phases = rng.uniform(0.0, 2.0 * np.pi, 14)
    force = 10.0 * np.sin(np.multiply.outer(t, np.linspace(0.8, 15.0, 14)) + phases).sum(axis=1)

    def rate(now, x):
        q, v, z = x
        own = np.interp(now - late, t, force) - 1.0 * v - 30.0 * q - 20.0 * z
        return [v, own, v - loss * abs(v) * z - bend * v * abs(z)]

    options = {"t_eval": t, "max_step": 0.01, "rtol": 1e-7, "atol": 1e-9}
    q = solve_ivp(rate, (0.0, t[-1]), [0.0] * 3, **options).y[0]
    return pse.prepare(t, q + noise * q.std() * rng.standard_normal(len(t)), force)


@pytest.mark.slow
@pytest.mark.parametrize(("loss", "bend", "seed"), [(0.6, -0.8, 0), (0.5, -0.5, 1)])
def test_spring_that_forgets_is_found_with_its_numbers(loss, bend, seed):
    report = pse.close_loop(
        DECLARED, mount(loss, bend, seed), operators=(), n_twins=59, random_state=0
    )
    (effect,) = report.effects
    assert (effect.name, str(effect.term)) == ("hysteresis", "q_hyst")
    assert "forgets a turn over a length of" in str(report)
    assert "q_hyst' = " in str(report)
    assert report.model.feature_names == ["q", "v", "q_hyst", "F"]
    (path,) = paths_in(report.equations.inner)
    length, share = kind_of(path).numbers(path)
    assert 1.0 / length == pytest.approx(loss - bend, rel=0.1)
    assert share / length == pytest.approx(loss, rel=0.1)
    assert effect.coefficients[0] / length == pytest.approx(-20.0, rel=0.1)
    assert report.after.simulation_error[0] < 0.02 * report.before.simulation_error[0]
    w, v = sympy.Symbol("q_hyst", real=True), sympy.Symbol("v", real=True)
    (_, _, hidden) = report.equations.to_sympy()
    assert hidden.free_symbols == {w, v}


@pytest.mark.slow
def test_spring_that_forgets_is_found_beside_a_force_that_comes_late():
    record = mount(0.6, -0.8, 0, late=0.03)
    report = pse.close_loop(DECLARED, record, operators=(), random_state=0)
    assert {effect.name for effect in report.effects} == {"hysteresis", "input delay"}
    assert report.after.simulation_error[0] < 0.02 * report.before.simulation_error[0]
