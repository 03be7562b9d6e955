"""Bouc and Wen's hysteresis: the path operator, its hidden state, and how it is found."""

import numpy as np
import pytest
import sympy
from loop_systems import equations_of
from scipy.integrate import solve_ivp

import pysindy_evolve as pse
from pysindy_evolve.equations import AlgebraicEquations, Equations
from pysindy_evolve.export import format_equations
from pysindy_evolve.hidden_states.boucwen import yielding, yielding_along
from pysindy_evolve.hidden_states.memory_equations import with_memories
from pysindy_evolve.hidden_states.path_states import paths_in
from pysindy_evolve.terms import value_of, variable

DECLARED = pse.DeclaredModel({"F": "c*v + k*x + F0"}, inputs=["x", "v"], algebraic=True)
T = np.arange(0.0, 20.0, 0.001)


def swing(t):
    """Position from zero, and velocity."""
    x = np.sin(t) + 0.6 * np.sin(2.3 * t + 1.0) - 0.6 * np.sin(1.0)
    return x, np.cos(t) + 1.38 * np.cos(2.3 * t + 1.0)


def damper(length, unloading, size=8.0, seed=0, noise=0.02, duration=30.0):
    """Measure the force of a damper whose friction remembers the path."""
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, duration, 0.01)
    frequencies = 2 * np.pi * np.array([0.3, 0.55, 0.8, 1.1, 1.45])
    arguments = np.outer(t, frequencies) + rng.uniform(0, 2 * np.pi, 5)
    x, v = np.sin(arguments).sum(axis=1), (np.cos(arguments) * frequencies).sum(axis=1)
    force = 2.0 * v + 3.0 * x + 1.0 + size * yielding_along(x, length, unloading)
    force = force + noise * force.std() * rng.standard_normal(len(t))
    return pse.Record(t=t, x=force, x_dot=force, u=np.column_stack([x, v]))


def close(record, test=None, **options):
    settings = {"operators": (), "random_state": 0, "n_twins": 59} | options
    return pse.close_loop(DECLARED, record, test, **settings)


def with_yield(kind, coef, states, inputs, position, velocity):
    """Equations of one row: a hysteresis of L = 0.3 and k = 2, then the velocity."""
    path = yielding(variable(position), variable(velocity), 0.3, 2.0)
    terms = tuple(part[0][1] for part in (path.parts, variable(velocity).parts))
    return kind(terms, np.array(coef, dtype=float), states, inputs)


@pytest.mark.parametrize(("length", "unloading"), [(0.1, 1.0), (0.3, 0.25), (0.05, 4.0)])
def test_path_operator_solves_the_differential_equation(length, unloading):
    beta, gamma = 0.5 * (1.0 + unloading), 0.5 * (1.0 - unloading)

    def rate(t, w):
        v = swing(t)[1]
        return (v - beta * abs(v) * w - gamma * v * abs(w)) / length

    exact = solve_ivp(rate, (0.0, T[-1]), [0.0], t_eval=T, rtol=1e-9, atol=1e-10, max_step=0.01)
    assert yielding_along(swing(T)[0], length, unloading) == pytest.approx(exact.y[0], abs=1e-4)


def test_path_operator_is_exact_on_a_straight_path_whatever_the_samples():
    x = np.array([0.0, 0.2, 0.5, 0.5, 1.1, 0.4])
    w = yielding_along(x, 0.5, 1.0)
    up = 1.0 - np.exp(-1.1 / 0.5)
    assert w[4] == pytest.approx(up)
    assert w[5] == pytest.approx(-1.0 + (1.0 + up) * np.exp(-0.7 / 0.5))  # Dahl: one exponential


def test_path_operator_does_not_depend_on_the_zero_or_the_direction_of_the_position():
    x = swing(T)[0]
    w = yielding_along(x, 0.3, 0.5)
    assert yielding_along(x + 40.0, 0.3, 0.5) == pytest.approx(w, abs=1e-9)
    assert yielding_along(-x, 0.3, 0.5) == pytest.approx(-w)


def test_hysteresis_is_written_as_a_state_with_an_equation_of_its_own():
    plain = with_yield(AlgebraicEquations, [[8.0, 2.0]], ("F",), ("x", "v"), 1, 2)
    full = with_memories(plain, ())
    assert full.states == ("F", "x_yield")
    w, v = sympy.Symbol("x_yield", real=True), sympy.Symbol("v", real=True)
    force, rate = full.to_sympy()
    assert sympy.expand(force - (8 * w + 2 * v)) == 0
    expected = (v - sympy.Rational(3, 2) * abs(v) * w + v * abs(w) / 2) / sympy.Rational(3, 10)
    assert sympy.lambdify((w, v), rate)(0.3, -2.0) == pytest.approx(
        float(expected.subs({w: 0.3, v: -2.0}))
    )
    first, second = format_equations(full).splitlines()
    assert first.startswith("F = ")
    assert second.startswith("x_yield' = ")


def test_simulated_hidden_state_agrees_with_the_path_operator():
    plain = with_yield(Equations, [[0.0, 1.0], [-20.0, -0.5]], ("q", "v"), (), 0, 1)
    full = with_memories(plain, ())
    run = pse.simulate(full, [1.0, 0.0], T, tolerance=1e-8)
    assert run.shape == (len(T), 3)
    assert yielding_along(run[:, 0], 0.3, 2.0) == pytest.approx(run[:, 2], abs=2e-3)
    assert full.along(run[:, :2], None, T)[:, 0] == pytest.approx(run[:, 2], abs=2e-3)


def test_equations_without_hysteresis_stay_as_they_are():
    plain = equations_of({"q": "-q"})
    assert paths_in(plain) == ()
    assert with_memories(plain, ()) is plain


@pytest.mark.slow
@pytest.mark.parametrize(("length", "unloading"), [(0.3, 1.0), (1.0, 0.3), (0.15, 3.0)])
@pytest.mark.parametrize("seed", [0, 2])
def test_hysteresis_of_a_damper_is_found_with_its_numbers(length, unloading, seed):
    other = damper(length, unloading, seed=seed + 50, duration=10.0)
    report = close(damper(length, unloading, seed=seed), test=other)
    (effect,) = report.effects
    assert effect.name == "hysteresis"
    assert str(effect.term) == "x_yield"
    assert effect.coefficients == pytest.approx([8.0], rel=0.05)
    (path,) = report.equations.paths
    assert value_of(path.args[2]) == pytest.approx(length, rel=0.15)
    assert value_of(path.args[3]) == pytest.approx(unloading, rel=0.5)
    assert report.after.derivative_error[0] < 0.1 * report.before.derivative_error[0]


@pytest.mark.slow
def test_found_hysteresis_is_a_state_of_the_reported_model_and_its_runs():
    report = close(damper(0.3, 1.0))
    assert report.model.feature_names == ["F", "x_yield", "x", "v"]
    record = report.test[0]
    run = report.simulate(record)
    assert run.shape == (len(record), 2)
    miss = run[:, 0] - record.x[:, 0]
    assert np.std(miss) < 0.05 * record.x.std()
    rates = report.model.predict(run, u=record.u)
    assert rates[:, 0] == pytest.approx(run[:, 0])
    steps = 0.5 * (rates[1:, 1] + rates[:-1, 1]) * np.diff(record.t)  # less sure at each turn
    assert np.std(np.diff(run[:, 1]) - steps) < 0.05 * np.diff(run[:, 1]).std()
    text = str(report)
    assert "times x_yield " in text
    assert "    x_yield' = " in text
    assert report.residual_after[0][:, 0] == pytest.approx(-miss)
