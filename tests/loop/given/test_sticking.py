"""Which rows say nothing of a friction: those at rest, and those mixed with them by a low-pass."""

import numpy as np
import pytest
from loop_systems import equations_of
from scipy.signal import lfilter

import pysindy_evolve as pse
from pysindy_evolve.loop.given.sticking import may_rest, weights_in_motion

BELT = pse.DeclaredModel({"v": "b*F - c*v - f*sgn(v)"}, inputs=["F"])
FREE_BELT = pse.DeclaredModel({"v": "b*F - c*v"}, inputs=["F"])
STICKS = {"q": "v", "v": "3*u - 4*v - 3*sgn(v)"}


@pytest.fixture(scope="module")
def sticking():
    t = np.arange(0.0, 40.0, 0.01)
    u = 1.6 * np.sin(2.0 * np.pi * 0.7 * t)
    x = pse.simulate(equations_of(STICKS, ("u",)), [0.0, 0.0], t, u)
    return pse.prepare(t, np.round(x[:, 0], 5), u)


def test_rows_next_to_a_rest_have_no_weight_and_turning_points_hardly_cost_any(sticking):
    weight = weights_in_motion(sticking, [1])[:, 1]
    left = sticking.x_dot[:, 1] - (
        3.0 * sticking.u[:, 0] - 4.0 * sticking.x[:, 1] - 3.0 * np.sign(sticking.x[:, 1])
    )
    assert np.abs(left[weight == 1.0]).max() < 0.3
    assert np.abs(left[weight == 0.0]).max() > 2.0
    assert 0.5 < np.mean(weight) < 0.9
    t = np.arange(0.0, 20.0, 0.01)
    swing = pse.prepare(t, np.sin(3.0 * t))
    assert np.mean(weights_in_motion(swing, [1])[:, 1]) > 0.98


def test_friction_of_a_machine_that_sticks_is_fitted_without_bias(sticking):
    declared = pse.DeclaredModel({"q": "v", "v": "b*u - c*v - f*sgn(v)"}, inputs=["u"])
    report = pse.close_loop(declared, sticking, max_effects=0, operators=(), random_state=0)
    found = report.before.parameters
    assert [found[name] for name in "bcf"] == pytest.approx([3.0, 4.0, 3.0], rel=0.02)


def belt(seed, *, rests=True):
    """Measure the speed alone of a belt that stops again and again, with colored noise."""
    rng, t = np.random.default_rng(seed), np.arange(0.0, 30.0, 0.01)
    levels = [0.0, 0.0, 0.0, 3.0, 5.0, -4.0] if rests else [3.0, 5.0, 7.0]
    force = lfilter([0.1], [1.0, -0.9], np.repeat(rng.choice(levels, 30), 100))
    v = np.zeros(len(t))
    for i in range(len(t) - 1):  # the force is held; over a step what is left of it is straight
        push = 4.0 * force[i] - 2.0 * v[i]
        rubs = 3.0 * np.sign(v[i] or np.sign(push)) if v[i] or abs(push) > 3.0 else push
        level = (4.0 * force[i] - rubs) / 2.0
        v[i + 1] = level + (v[i] - level) * np.exp(-0.02)
        if v[i] * v[i + 1] < 0.0:
            v[i + 1] = 0.0
    noise = 0.02 * lfilter([np.sqrt(0.75)], [1.0, -0.5], rng.standard_normal(len(t)))
    return pse.prepare(t, v + noise, force, order=1, held=True)


def test_a_speed_of_the_first_order_rests_as_any_other():
    record, moves = belt(0), belt(0, rests=False)
    assert may_rest(BELT.design(), [moves]) == (0,)  # a friction is declared
    assert may_rest(FREE_BELT.design(), [record]) == (0,)
    assert may_rest(FREE_BELT.design(), [moves]) == ()


@pytest.mark.slow
def test_noise_of_a_speed_at_rest_is_no_effect():
    assert pse.close_loop(BELT, belt(1), test=belt(2), random_state=0).effects == []


@pytest.mark.slow
def test_friction_of_a_belt_that_stops_is_found_alone():
    report = pse.close_loop(FREE_BELT, belt(1), belt(2), operators=(), random_state=0)
    (effect,) = report.effects
    assert str(effect.term) == "sign(v)"
    assert effect.coefficients == pytest.approx([-3.0], rel=0.03)
