"""Which rows say nothing of a friction: those at rest, and those mixed with them by a low-pass."""

import numpy as np
import pytest
from loop_systems import equations_of

import pysindy_evolve as pse
from pysindy_evolve.loop.given.sticking import moving

STICKS = {"q": "v", "v": "3*u - 4*v - 3*sgn(v)"}


@pytest.fixture(scope="module")
def sticking():
    t = np.arange(0.0, 40.0, 0.01)
    u = 1.6 * np.sin(2.0 * np.pi * 0.7 * t)
    x = pse.simulate(equations_of(STICKS, ("u",)), [0.0, 0.0], t, u)
    return pse.prepare(t, np.round(x[:, 0], 5), u)


def test_rows_next_to_a_rest_have_no_weight_and_turning_points_hardly_cost_any(sticking):
    weight = moving(sticking, [1])[:, 1]
    left = sticking.x_dot[:, 1] - (
        3.0 * sticking.u[:, 0] - 4.0 * sticking.x[:, 1] - 3.0 * np.sign(sticking.x[:, 1])
    )
    assert np.abs(left[weight == 1.0]).max() < 0.3
    assert np.abs(left[weight == 0.0]).max() > 2.0
    assert 0.5 < np.mean(weight) < 0.9
    t = np.arange(0.0, 20.0, 0.01)
    swing = pse.prepare(t, np.sin(3.0 * t))
    assert np.mean(moving(swing, [1])[:, 1]) > 0.98


def test_friction_of_a_machine_that_sticks_is_fitted_without_bias(sticking):
    declared = pse.DeclaredModel({"q": "v", "v": "b*u - c*v - f*sgn(v)"}, inputs=["u"])
    report = pse.close_loop(declared, sticking, max_effects=0, operators=(), random_state=0)
    found = report.before.parameters
    assert [found[name] for name in "bcf"] == pytest.approx([3.0, 4.0, 3.0], rel=0.02)
