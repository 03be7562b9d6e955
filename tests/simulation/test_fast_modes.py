"""Modes that decay much faster than the samples come: stiff equations."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from pysindy_evolve.operators import BUILTIN, Operator
from pysindy_evolve.simulation import simulate
from pysindy_evolve.terms import add, call, constant, mul, power, variable

from .sliding_systems import equations, sgn, total


@pytest.mark.parametrize("rate", [100.0, 500.0, 5000.0])
@pytest.mark.parametrize("step", [0.001, 0.02, 0.1])
def test_a_fast_decay_is_right_at_any_sampling(rate, step):
    """The first trial step, unstable, left its huge values as the scale of the error."""
    t = np.arange(0.0, 2.0, step)
    x = simulate(equations([total((-rate, variable(0)))], ("x",)), [1.0], t)
    np.testing.assert_allclose(x[:, 0], np.exp(-rate * t), atol=1e-8)


@pytest.mark.parametrize("step", [0.001, 0.01, 0.1, 1.0])
def test_large_terms_that_cancel_leave_no_room_for_an_error(step):
    row = total((-1e3, power(variable(0), 3)), (1e3, power(variable(1), 3)))
    t = np.arange(0.0, 5.0, step)
    u = 1.0 + 1e-3 * np.sin(t)
    x = simulate(equations([row], ("x",), ("u",)), [1.0], t, u)

    def rates(time, x):
        return 1e3 * (np.interp(time, t, u) ** 3 - x**3)

    exact = solve_ivp(
        rates, (0, t[-1]), [1.0], "Radau", t, rtol=1e-11, atol=1e-12, max_step=step
    ).y[0]
    np.testing.assert_allclose(x[:, 0], exact, atol=2e-6)


def test_a_lag_before_a_block_that_sticks_and_slips():
    q, v, force, command = (variable(i) for i in range(4))
    rows = [
        v,
        total((-2.0, sgn(v)), (1.0, force), (-1.0, q)),
        total((-500.0, force), (500.0, command)),
    ]
    rig = equations(rows, ("q", "v", "F"), ("c",))
    t = np.arange(0.0, 15.0, 0.1)
    fine = np.linspace(0.0, t[-1], 100 * (len(t) - 1) + 1)
    u = 3 * np.sin(t)
    coarse = simulate(rig, [0.0, 0.0, 0.0], t, u)
    exact = simulate(rig, [0.0, 0.0, 0.0], fine, np.interp(fine, t, u), tolerance=1e-12)
    np.testing.assert_allclose(coarse, exact[::100], atol=1e-7)
    assert np.count_nonzero(coarse[:, 1] == 0.0) > 5


def test_a_state_that_starts_at_zero_does_not_hold_up_the_run():
    """Robertson's reaction: nothing tells the size of the products at the start."""
    a, b = variable(0), variable(1)
    slow, back, fast = (0.04, a), (1e4, mul(b, variable(2))), (3e7, power(b, 2))
    rows = [
        total((-slow[0], a), back),
        total(slow, (-back[0], back[1]), (-fast[0], fast[1])),
        total(fast),
    ]
    t = np.linspace(0.0, 4.0, 5)
    x = simulate(equations(rows, ("a", "b", "c")), [1.0, 0.0, 0.0], t)
    assert x.sum(axis=1) == pytest.approx(1.0, abs=1e-9)
    assert x[-1, 0] == pytest.approx(0.9055186, abs=1e-6)


class TestLimits:
    stiff = equations([total((-1e6, variable(0)), (1e6, variable(1)))], ("x",), ("u",))
    t = np.linspace(0.0, 0.2, 3)

    def test_too_many_steps_are_told_as_such_and_raising_the_limit_helps(self):
        with pytest.warns(RuntimeWarning, match=r"stopped at t = 0.1 .* raise max_steps"):
            x = simulate(self.stiff, [0.0], self.t, np.sin(self.t))
        assert np.isnan(x[1:]).all()
        x = simulate(self.stiff, [0.0], self.t, np.sin(self.t), max_steps=10**6)
        np.testing.assert_allclose(x[1:, 0], np.sin(self.t[1:]), atol=2e-6)

    def test_the_default_limit_is_above_the_substeps_that_were_asked_for(self):
        decay = equations([total((-1.0, variable(0)))], ("x",))
        t = np.linspace(0.0, 5.0, 21)
        x = simulate(decay, [1.0], t, substeps=3000)
        np.testing.assert_allclose(x[:, 0], np.exp(-t), atol=1e-10)
        x = simulate(decay, [1.0], t[:2], substeps=12_000)
        np.testing.assert_allclose(x[:, 0], np.exp(-t[:2]), atol=1e-10)

    def test_a_jump_without_sgn_at_which_the_motion_sticks_ends_the_run(self):
        jump = Operator("jump", lambda a: np.where(a > 0.0, 1.0, -1.0), 1)
        slowed = equations([mul(constant(-2.0), call(jump, variable(0)))], ("x",))
        with pytest.warns(RuntimeWarning, match="must be a sgn"):
            x = simulate(slowed, [1.0], np.linspace(0.0, 1.0, 11))
        assert x[4, 0] == pytest.approx(0.2)
        assert np.isnan(x[-1, 0])

    def test_a_jump_without_sgn_is_crossed(self):
        jump = Operator("jump", lambda a: np.where(a > 0.0, 1.0, -1.0), 1)
        row = add(constant(0.3), call(jump, add(variable(1), constant(-0.5))))
        t = np.linspace(0.0, 1.0, 12)
        x = simulate(equations([row], ("x",), ("u",)), [0.0], t, t)
        np.testing.assert_allclose(x[:, 0], 0.3 * t + np.abs(t - 0.5) - 0.5, atol=1e-7)

    def test_a_steep_switch_follows_its_input(self):
        steep = call(BUILTIN["tanh"], total((1e3, variable(0)), (-1e3, variable(1))))
        t = np.linspace(0.0, 1.0, 11)
        follower = equations([mul(constant(-100.0), steep)], ("x",), ("u",))
        x = simulate(follower, [0.0], t, np.sin(t), max_steps=10**6)
        np.testing.assert_allclose(x[:, 0], np.sin(t), atol=2e-5)
