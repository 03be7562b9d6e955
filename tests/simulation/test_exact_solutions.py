"""Free runs against solutions in closed form."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from pysindy_evolve.operators import BUILTIN
from pysindy_evolve.simulation import simulate
from pysindy_evolve.terms import call, constant, mul, power, sub, variable

from .sliding_systems import block, coulomb_oscillator, equations, q, sgn, third, total, v


class TestExactSolutions:
    def test_coulomb_oscillator_loses_the_same_amplitude_each_half_period_and_stops(self):
        t = np.linspace(0.0, 5.0, 731)
        x = simulate(block(friction=8.0, stiffness=100.0, inputs=()), [1.0, 0.0], t)
        exact = coulomb_oscillator(t, 1.0, 10.0, 8.0)
        np.testing.assert_allclose(x, exact, atol=2e-8)
        assert np.count_nonzero(x[:, 1] == 0.0) == np.count_nonzero(exact[:, 1] == 0.0) > 300

    def test_block_stops_at_the_exact_time_and_place(self):
        t = np.array([0.0, 0.2, 0.5, 0.8, 3.0])
        x = simulate(block(inputs=()), [0.0, 1.0], t)
        np.testing.assert_allclose(x[:, 0], [0.0, 0.16, 0.25, 0.25, 0.25], atol=1e-12)
        assert x[2, 1] == pytest.approx(0.0, abs=1e-12)
        assert np.all(x[3:, 1] == 0.0)
        assert np.all(x[3:, 0] == x[3, 0])

    def test_block_sticks_under_a_slow_ramp_until_it_breaks_away(self):
        t = np.linspace(0.0, 4.0, 37)
        x = simulate(block(), [0.0, 0.0], t, t)
        late = np.maximum(t - 2.0, 0.0)
        np.testing.assert_allclose(x[:, 0], late**3 / 6, atol=1e-12)
        np.testing.assert_allclose(x[:, 1], late**2 / 2, atol=1e-12)
        assert np.all(x[t <= 2.0] == 0.0)

    def test_block_on_a_belt_rides_and_slips(self):
        row = total((-4.0, q), (-2.0, sgn(sub(v, constant(1.0)))))
        t = np.linspace(0.0, 0.5 + np.pi, 400)
        x = simulate(equations([v, row], ("q", "v")), [0.0, 1.0], t)
        rides = t <= 0.5
        np.testing.assert_allclose(x[rides], np.column_stack([t, 0 * t + 1])[rides], atol=1e-12)
        phase = 2.0 * (t[~rides] - 0.5)
        np.testing.assert_allclose(x[~rides, 0], 0.5 + 0.5 * np.sin(phase), atol=1e-8)

    def test_belt_with_measured_speed_carries_the_block_along(self):
        row = mul(constant(-3.0), sgn(sub(variable(0), variable(1))))
        t = np.linspace(0.0, 6.0, 601)
        belt = np.sin(t)
        x = simulate(equations([row], ("v",), ("w",)), [0.0], t, belt)
        np.testing.assert_allclose(x[:, 0], belt, atol=1e-13)

    def test_two_blocks_slide_as_one_and_then_apart(self):
        """A block on a block: together while the lower one accelerates less than 1."""
        v1, v2, force = variable(0), variable(1), variable(2)
        rows = [
            mul(constant(-1.0), sgn(sub(v1, v2))),
            total((1.0, sgn(sub(v1, v2))), (1.0, force)),
        ]
        t = np.linspace(0.0, 6.0, 241)
        x = simulate(equations(rows, ("v1", "v2"), ("F",)), [0.0, 0.0], t, t)
        joint = t <= 2.0
        np.testing.assert_allclose(x[joint, 0], t[joint] ** 2 / 4, atol=1e-11)
        np.testing.assert_allclose(x[joint, 1], x[joint, 0], atol=1e-13)
        late = t[~joint] - 2.0
        np.testing.assert_allclose(x[~joint, 0], 1.0 + late, atol=1e-9)
        np.testing.assert_allclose(x[~joint, 1], 1.0 + late + late**2 / 2, atol=1e-9)

    def test_two_masses_with_friction_each_stick_and_slip_on_their_own(self):
        q1, v1, q2, v2, force = (variable(i) for i in range(5))
        rows = [
            v1,
            total((-3.0, q1), (2.0, q2), (-1.0, sgn(v1)), (1.0, force)),
            v2,
            total((2.0, q1), (-3.0, q2), (-0.5, sgn(v2))),
        ]
        two = equations(rows, ("q1", "v1", "q2", "v2"), ("F",))
        t = np.linspace(0.0, 30.0, 3001)
        x = simulate(two, np.zeros(4), t, 2.5 * np.sin(0.4 * t))
        stuck = x[:, [1, 3]] == 0.0
        for states in ([True, True], [True, False], [False, True], [False, False]):
            assert np.count_nonzero((stuck == states).all(axis=1)) > 20
        fine = simulate(two, np.zeros(4), t, 2.5 * np.sin(0.4 * t), tolerance=1e-12)
        np.testing.assert_allclose(x, fine, atol=1e-7)

    def test_linear_system_agrees_with_the_matrix_exponential(self):
        matrix = np.array([[0.0, 1.0], [-40.0, -0.7]])
        rows = [total(*zip(row, (q, v), strict=True)) for row in matrix]
        t = np.cumsum(np.r_[0.0, np.random.default_rng(0).uniform(0.001, 0.4, 60)])
        x = simulate(equations(rows, ("q", "v")), [1.0, -2.0], t)
        exact = np.array([expm(matrix * time) @ [1.0, -2.0] for time in t])
        np.testing.assert_allclose(x, exact, atol=1e-7)

    def test_asymmetric_friction_has_its_own_level_for_each_direction(self):
        row = total((-2.0, sgn(v)), (0.5, power(q, 0)), (1.0, third))
        asymmetric = equations([v, row], ("q", "v"), ("F",))
        t = np.linspace(0.0, 4.0, 41)
        forward, backward = (simulate(asymmetric, [0, 0], t, s * t) for s in (1.0, -1.0))
        assert np.all(forward[t <= 1.5, 1] == 0.0)
        assert np.all(backward[t <= 2.5, 1] == 0.0)
        assert forward[16, 1] > 0.0 > backward[26, 1]

    def test_stribeck_friction_breaks_away_at_its_largest_value(self):
        dip = call(BUILTIN["exp"], mul(constant(-100.0), power(v, 2)))
        row = total((-1.0, sgn(v)), (-0.5, mul(sgn(v), dip)), (1.0, third))
        t = np.linspace(0.0, 2.0, 201)
        x = simulate(equations([v, row], ("q", "v"), ("F",)), [0.0, 0.0], t, t)
        assert np.all(x[t <= 1.5, 1] == 0.0)
        assert x[151, 1] > 0.0

    def test_position_dependent_friction_does_not_hold_where_it_vanishes(self):
        row = total((-8.0, mul(power(q, 2), sgn(v))), (1.0, third))
        rig = equations([v, row], ("q", "v"), ("F",))
        t = np.linspace(0.0, 1.0, 11)
        assert simulate(rig, [0.0, 0.0], t, 0.1 + 0 * t)[1, 0] > 0.0
        assert np.all(simulate(rig, [0.5, 0.0], t, 1.9 + 0 * t) == [0.5, 0.0])

    def test_sign_of_an_input_jumps_with_the_input(self):
        row = sgn(variable(1))
        u = [0, 0, 1, 1, 0, 0, -1, 1, -1]
        x = simulate(equations([row], ("x",), ("u",)), [0.0], np.arange(9.0), u)
        np.testing.assert_allclose(x[:, 0], [0, 0, 1, 2, 3, 3, 2, 2, 2], atol=1e-9)

    def test_magnetic_switch_on_position_is_crossed_and_not_stuck_to(self):
        row = total((-1.0, sgn(q)))
        t = np.linspace(0.0, 4.0 * np.sqrt(2.0), 101)
        x = simulate(equations([v, row], ("q", "v")), [1.0, 0.0], t)
        np.testing.assert_allclose(x[-1], [1.0, 0.0], atol=1e-8)
        np.testing.assert_allclose(x[50], [-1.0, 0.0], atol=1e-8)


@pytest.mark.parametrize("exponent", [0.5, 0.6, 1.75])
def test_a_power_of_the_speed_beside_its_sign_is_followed_through_zero(exponent: float) -> None:
    q, v = variable(0), variable(1)
    size = call(BUILTIN["abs"], v)
    exponential = call(BUILTIN["exp"], mul(constant(exponent), call(BUILTIN["log"], size)))
    drag = mul(call(BUILTIN["sqrt"], size) if exponent == 0.5 else exponential, sgn(v))
    t = np.arange(0.0, 3.0, 0.01)
    system = equations([v, total((-20.0, q), (-0.6, v), (-1.0, drag))], ("q", "v"))
    run = simulate(system, [0.1, 0.0], t)

    def rates(_: float, x: np.ndarray) -> list[float]:
        drag = abs(x[1]) ** exponent * np.sign(x[1])
        return [x[1], -20 * x[0] - 0.6 * x[1] - drag]

    reference = solve_ivp(rates, (0.0, 3.0), [0.1, 0.0], t_eval=t, max_step=1e-3).y.T
    np.testing.assert_allclose(run, reference, atol=2e-4)
