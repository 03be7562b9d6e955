"""An equation such as q' = v holds for the records, or it may lack something like any other."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import pysindy_evolve as pse
from pysindy_evolve.loop.given.kinematics import disagreement, whole_state
from pysindy_evolve.terms import Sum, constant, mul, variable

T = np.arange(0.0, 30.0, 0.01)
DECLARED = pse.DeclaredModel({"x": "y", "y": "-k*x - c*y + b*F"}, inputs=["F"])


def force(t):
    return np.sin(1.3 * t) + np.sin(3.1 * t)


def record(cubic, unit=1.0, noise=2e-3):
    """Both states are measured, y in a unit of its own; x' lacks a cubic term in the model."""

    def rates(t, z):
        return z[1] - cubic * z[0] ** 3, -z[0] - 0.1 * z[1] + force(t)

    z = solve_ivp(rates, (0.0, T[-1]), (1.0, 0.0), t_eval=T, rtol=1e-8, atol=1e-9).y
    rng = np.random.default_rng(0)
    x = z.T * [1.0, unit] + noise * z.std(axis=1) * [1.0, unit] * rng.standard_normal(z.T.shape)
    x_dot = np.column_stack(rates(T, z)) * [1.0, unit]
    return pse.Record(T, x, x_dot, force(T))


def test_a_state_is_a_right_hand_side_only_if_nothing_stands_beside_it():
    v, q = variable(1), variable(0)
    assert whole_state(v, 0, 2) == 1
    assert whole_state(v, 1, 2) is None  # the state itself
    assert whole_state(v, 0, 1) is None  # an input
    assert whole_state(mul(constant(1.0005), v), 0, 2) is None
    assert whole_state(mul(v, q), 0, 2) is None
    assert whole_state(Sum(()), 0, 2) is None


@pytest.mark.parametrize(("cubic", "unit", "expected"), [(0.0, 1.0, 0.0), (0.0, 1e3, 999.0)])
def test_how_far_a_rate_is_from_what_is_said_to_be_it(cubic, unit, expected):
    assert disagreement([record(cubic, unit)], 0, 1) == pytest.approx(expected, rel=0.05, abs=0.01)


@pytest.mark.slow
def test_a_term_is_found_in_the_equation_that_looked_as_if_it_lacked_nothing():
    report = pse.close_loop(DECLARED, record(0.5), operators=(), random_state=0)
    (effect,) = report.effects
    assert (effect.state, effect.coefficients[0]) == ("x", pytest.approx(-0.5, rel=0.01))
    assert "The records contradict the declared x' = y: dx/dt differs from y by" in " ".join(
        str(report).split()
    )


def test_nothing_is_doubted_where_a_velocity_is_measured_with_noise():
    report = pse.close_loop(DECLARED, record(0.0, noise=0.05), operators=(), random_state=0)
    assert report.verdict == "complete"
    assert "contradict" not in str(report)


@pytest.mark.slow
def test_a_velocity_in_another_unit_is_not_complete():
    report = pse.close_loop(DECLARED, record(0.0, unit=1e3), operators=(), random_state=0)
    assert report.verdict != "complete"
    assert "Check the units of y" in " ".join(str(report).split())
