"""Free runs and windows against exact solutions, scipy, and themselves."""

from types import SimpleNamespace

import numpy as np
import pysindy as ps
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm
from scipy.optimize import brentq

from pysindy_evolve.equations import Equations
from pysindy_evolve.operators import BUILTIN, Operator
from pysindy_evolve.simulation import simulate, simulate_windows
from pysindy_evolve.terms import ONE, Sum, add, call, constant, mul, power, sub, variable


def equations(rows, states, inputs=()):
    """Build Equations from one Sum for each state."""
    terms = tuple(dict.fromkeys(term for row in rows for _, term in row.parts))
    coef = np.zeros((len(rows), len(terms)))
    for i, row in enumerate(rows):
        for coefficient, term in row.parts:
            coef[i, terms.index(term)] = coefficient
    return Equations(terms, coef, tuple(states), tuple(inputs))


def total(*parts: tuple[float, Sum]) -> Sum:
    result = constant(0.0)
    for coefficient, term in parts:
        result = add(result, mul(constant(coefficient), term))
    return result


def sgn(argument: Sum) -> Sum:
    return call(BUILTIN["sgn"], argument)


q, v, third = variable(0), variable(1), variable(2)


def block(friction=2.0, stiffness=0.0, damping=0.0, inputs=("F",)):
    """q'' = -stiffness q - damping v - friction sgn(v) + F."""
    force = [(1.0, third)] if inputs else []
    row = total((-stiffness, q), (-damping, v), (-friction, sgn(v)), *force)
    return equations([v, row], ("q", "v"), inputs)


def duffing():
    """The friction rig of the paper, equation (7), coefficients of experiment 1."""
    friction = mul(power(q, 2), sgn(v))
    row = total(
        (-1.1, v), (-691.92, q), (-2.37e6, power(q, 3)), (-2.93, sgn(v)), (-7.63e3, friction),
        (-1.0, third),
    )  # fmt: skip
    return equations([v, row], ("q", "v"), ("zdd",))


def coulomb_oscillator(t, q0, omega, mu):
    """Exact free motion of q'' = -omega^2 q - mu sgn(v) from rest at q0 > 0."""
    out, start, begin = np.empty((len(t), 2)), q0, 0.0
    half, offset = np.pi / omega, mu / omega**2
    while abs(start) > offset:
        center = np.sign(start) * offset
        swing = (t >= begin) & (t < begin + half)
        phase = omega * (t[swing] - begin)
        out[swing, 0] = center + (start - center) * np.cos(phase)
        out[swing, 1] = -(start - center) * omega * np.sin(phase)
        start, begin = 2 * center - start, begin + half
    out[t >= begin] = (start, 0.0)
    return out


@pytest.fixture(scope="module")
def sweep():
    t = np.linspace(0.0, 2.0, 4001)
    return t, 9.0 * np.sin(2 * np.pi * (4.0 * t + t**2))


@pytest.fixture(scope="module")
def record():
    t = np.arange(6001) * 1e-3
    u = 9 * np.sin(2 * np.pi * (2 * t + 0.5 * t**2))
    return t, u, simulate(duffing(), [0.0, 0.0], t, u)


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


class TestDuffingFriction:
    def test_agrees_with_scipy_and_events(self, sweep):
        t, u = (column[:2001] for column in sweep)
        x = simulate(duffing(), [0.004, 0.0], t, u)
        exact = self.by_scipy(t, u, [0.004, 0.0])
        np.testing.assert_allclose(
            x / np.abs(exact).max(axis=0), exact / np.abs(exact).max(axis=0), atol=1e-6
        )

    @staticmethod
    def by_scipy(t, u, x0):
        """Integrate piece by piece between zeros of v, with Filippov's rule at each."""

        def net(time, x):
            return -1.1 * x[1] - 691.92 * x[0] - 2.37e6 * x[0] ** 3 - np.interp(time, t, u)

        def slack(time, x):
            return 2.93 + 7.63e3 * x[0] ** 2 - abs(net(time, x))

        def stop(time, x, sign):
            return x[1]

        def slide(time, x, sign):
            return [x[1], net(time, x) - sign * (2.93 + 7.63e3 * x[0] ** 2)]

        stop.terminal = True
        out, time, x = np.empty((len(t), 2)), t[0], np.array(x0)
        options = {"method": "DOP853", "rtol": 1e-11, "atol": 1e-14, "max_step": t[1] - t[0]}
        while time < t[-1]:
            begin = time
            if x[1] == 0.0 and slack(time, x) > 0:
                until = next((b for b in t[t > time] if slack(b, x) < 0), t[-1])
                free = slack(until, x) < 0
                time = brentq(slack, time, until, args=(x,), xtol=1e-15) if free else until
                out[(t >= begin) & (t <= time)] = x
                continue
            sign = np.sign(x[1]) or np.sign(net(time, x))
            stop.direction = -sign
            run = solve_ivp(
                slide, (time, t[-1]), x, events=stop, args=(sign,), dense_output=True, **options
            )
            time, x = run.t[-1], run.y[:, -1] * [1.0, 1.0 - run.status]
            inside = (t >= begin) & (t <= time)
            out[inside] = run.sol(t[inside]).T
        return out

    def test_velocity_changes_sign_no_more_often_than_the_motion_does(self, sweep):
        t, u = sweep
        x = simulate(duffing(), [0.004, 0.0], t, u)
        moving = np.sign(x[x[:, 1] != 0.0, 1])
        assert 10 < np.count_nonzero(np.diff(moving)) < 40

    def test_stays_at_rest_exactly_when_the_table_moves_gently(self, sweep):
        t, u = sweep
        x = simulate(duffing(), [0.0, 0.0], t, 0.3 * u)
        assert np.all(x == 0.0)

    def test_each_sample_rate_gives_the_same_motion(self):
        t = np.linspace(0.0, 2.0, 2001)
        u = np.interp(t, np.linspace(0, 2, 101), 9 * np.sin(np.linspace(0, 50, 101)))
        fine = simulate(duffing(), [0.0, 0.0], t, u)
        coarse = simulate(duffing(), [0.0, 0.0], t[::20], u[::20])
        np.testing.assert_allclose(coarse, fine[::20], atol=1e-8)

    def test_coefficients_change_without_a_new_program(self, sweep):
        from pysindy_evolve.simulation.program import program_of

        t, u = sweep
        simulate(duffing(), [0.0, 0.0], t[:20], u[:20])
        before = program_of.cache_info().misses
        changed = duffing()
        half = Equations(changed.terms, 0.5 * changed.coef, changed.states, changed.inputs)
        half.coef[0] = changed.coef[0]
        simulate(half, [0.0, 0.0], t[:20], u[:20])
        changed.coef[1] *= 1.01
        simulate(changed, [0.0, 0.0], t[:20], u[:20])
        assert program_of.cache_info().misses <= before + 1


class TestInputsAndTime:
    def test_input_is_linear_between_samples(self):
        integrator = equations([variable(1)], ("x",), ("u",))
        x = simulate(integrator, [0.0], [0.0, 1.0, 4.0], [0.0, 2.0, -1.0])
        np.testing.assert_allclose(x[:, 0], [0.0, 1.0, 2.5], atol=1e-12)

    def test_input_may_be_a_function_of_time(self):
        integrator = equations([variable(1)], ("x",), ("u",))
        t = np.linspace(0.0, 3.0, 61)
        x = simulate(integrator, [0.0], t, np.cos)
        np.testing.assert_allclose(x[:, 0], np.sin(t), atol=1e-5)

    def test_input_named_t_is_filled_with_time(self):
        ramp = equations([mul(variable(1), variable(2))], ("x",), ("u", "t"))
        t = np.linspace(0.0, 2.0, 21)
        x = simulate(ramp, [0.0], t, np.ones(21))
        np.testing.assert_allclose(x[:, 0], t**2 / 2, atol=1e-12)
        alone = equations([variable(1)], ("x",), ("t",))
        np.testing.assert_allclose(simulate(alone, [0.0], t)[:, 0], t**2 / 2, atol=1e-12)

    def test_time_itself_may_stand_in_a_term(self):
        forced = equations([call(BUILTIN["cos"], variable(1))], ("x",))
        t = np.linspace(1.0, 4.0, 31)
        x = simulate(forced, [0.0], t)
        np.testing.assert_allclose(x[:, 0], np.sin(t) - np.sin(1.0), atol=1e-9)

    def test_irregular_samples_give_the_same_motion_as_regular_ones(self):
        t = np.linspace(0.0, 3.0, 301)
        kept = np.sort(np.random.default_rng(1).choice(np.arange(1, 301), 60, replace=False))
        kept = np.r_[0, kept]
        rig = block(friction=1.0, stiffness=20.0, inputs=())
        all_samples = simulate(rig, [1.0, 0.0], t)
        np.testing.assert_allclose(simulate(rig, [1.0, 0.0], t[kept]), all_samples[kept], atol=1e-7)

    def test_fixed_substeps_converge(self):
        rig = block(friction=0.0, stiffness=400.0, inputs=())
        t = np.linspace(0.0, 1.0, 21)
        exact = np.cos(20 * t)
        errors = [
            np.abs(simulate(rig, [1.0, 0.0], t, substeps=n)[:, 0] - exact).max() for n in (1, 2, 4)
        ]
        assert errors[0] > 20 * errors[1] > 400 * errors[2]


class TestModels:
    def test_operator_of_the_user_is_called_as_it_was_scored(self):
        relu = Operator("relu", lambda a: np.maximum(a, 0.0), 1)
        row = mul(constant(-1.0), call(relu, sub(variable(0), constant(0.5))))
        t = np.linspace(0.0, 3.0, 31)
        x = simulate(equations([row], ("x",)), [1.5], t)
        np.testing.assert_allclose(x[:, 0], 0.5 + np.exp(-t), atol=1e-8)

    def test_inner_constants_are_simulated_with_their_values(self):
        for scale in (2.0, 3.0):
            row = call(BUILTIN["tanh"], mul(constant(scale), variable(1)))
            x = simulate(equations([row], ("x",), ("u",)), [0.0], [0.0, 1.0], [0.7, 0.7])
            assert x[1, 0] == pytest.approx(np.tanh(0.7 * scale), abs=1e-10)

    def test_same_threshold_in_two_terms_is_one_switch(self):
        from pysindy_evolve.simulation.structure import structure_of

        gate = sgn(sub(variable(0), constant(0.5)))
        row = total((-1.0, gate), (-1.0, mul(variable(0), gate)))
        assert len(structure_of(equations([row], ("x",)))[0].switches) == 1

    def test_fitted_sindy_and_objects_with_equations_are_taken(self):
        t = np.linspace(0.0, 4.0, 401)
        x = np.column_stack([np.cos(2 * t), -2 * np.sin(2 * t)])
        x_dot = np.column_stack([-2 * np.sin(2 * t), -4 * np.cos(2 * t)])
        model = ps.SINDy(feature_library=ps.PolynomialLibrary(1), optimizer=ps.STLSQ(0.1))
        model.fit(x, t, x_dot=x_dot)
        np.testing.assert_allclose(simulate(model, x[0], t), x, atol=1e-7)
        rig = block(inputs=())
        wrapped = simulate(SimpleNamespace(equations=rig), [0.0, 1.0], t)
        assert np.array_equal(wrapped, simulate(rig, [0.0, 1.0], t))

    def test_constant_rate(self):
        x = simulate(Equations((ONE,), np.array([[2.5]]), ("x",)), [1.0], [0.0, 2.0])
        np.testing.assert_allclose(x[:, 0], [1.0, 6.0], atol=1e-12)


class TestDivergence:
    @pytest.fixture
    def explosive(self):
        """x' = x^2 from 1 reaches infinity at t = 1.05."""
        return equations([mul(constant(1 / 1.05), power(variable(0), 2))], ("x",))

    def test_rest_is_nan_and_a_warning_names_the_time(self, explosive):
        t = np.linspace(0.0, 2.0, 21)
        with pytest.warns(RuntimeWarning, match=r"diverged at t = 1.1 \(sample 11\)"):
            x = simulate(explosive, [1.0], t)
        np.testing.assert_allclose(x[:11, 0], 1.05 / (1.05 - t[:11]), rtol=1e-6)
        assert np.isnan(x[11:]).all()

    def test_silent_and_raising(self, explosive):
        t = np.linspace(0.0, 2.0, 21)
        assert np.isnan(simulate(explosive, [1.0], t, on_divergence="nan")[-1, 0])
        with pytest.raises(FloatingPointError, match="diverged at t"):
            simulate(explosive, [1.0], t, on_divergence="raise")

    def test_leaving_the_domain_of_a_function_counts_as_divergence(self):
        row = sub(call(BUILTIN["sqrt"], variable(0)), constant(2.0))
        with pytest.warns(RuntimeWarning, match="diverged"):
            x = simulate(equations([row], ("x",)), [1.0], np.linspace(0.0, 5.0, 51))
        assert np.isfinite(x[0, 0])
        assert np.isnan(x[-1, 0])

    def test_bound_is_kept(self):
        t = np.linspace(0.0, 10.0, 101)
        with pytest.warns(RuntimeWarning, match="left the bound of 100"):
            x = simulate(equations([variable(0)], ("x",)), [1.0], t, bound=100.0)
        assert np.nanmax(x) <= 100.0

    def test_stiff_model_ends_with_a_warning_and_not_in_a_hang(self):
        row = total((-1e7, variable(0)), (1e7, variable(1)))
        stiff = equations([row], ("x",), ("u",))
        t = np.linspace(0.0, 10.0, 11)
        with pytest.warns(RuntimeWarning, match="steps"):
            simulate(stiff, [1.0], t, np.sin(t))


class TestWindows:
    @pytest.mark.parametrize("window", [20, 100, 1000])
    def test_each_window_follows_the_free_run(self, record, window):
        t, u, x = record
        predicted, index = simulate_windows(duffing(), x, t, u, window=window, substeps=4)
        assert predicted.shape == (6000 // window, window, 2)
        assert np.array_equal(index.ravel(), np.arange(1, 6001))
        np.testing.assert_allclose(predicted, x[index], atol=1e-4 * np.abs(x).max(axis=0).min())

    def test_automatic_substeps_are_enough(self, record):
        t, u, x = record
        coarse = slice(None, None, 8)
        once, index = simulate_windows(duffing(), x[coarse], t[coarse], u[coarse], window=25)
        spread = x.std(axis=0)
        assert np.all(np.sqrt(np.mean((once - x[coarse][index]) ** 2, axis=(0, 1))) < 0.02 * spread)

    def test_stuck_windows_rest_exactly(self, record):
        t, u, _ = record
        still = np.zeros((len(t), 2))
        still[:, 0] = 0.002
        predicted, _ = simulate_windows(duffing(), still, t, 0.05 * u, window=50)
        assert np.all(predicted == [0.002, 0.0])

    def test_windows_break_away_and_stop_as_the_free_run_does(self):
        t = np.linspace(0.0, 12.0, 1201)
        u = 3 * np.sin(t)
        x = simulate(block(stiffness=1.0), [0.0, 0.0], t, u)
        predicted, index = simulate_windows(block(stiffness=1.0), x, t, u, window=400)
        np.testing.assert_allclose(predicted, x[index], atol=2e-4)

    def test_joint_sliding_of_two_blocks(self):
        v1, v2, force = variable(0), variable(1), variable(2)
        rows = [
            total((-1.0, sgn(sub(v1, v2))), (-0.2, v1)),
            total((1.0, sgn(sub(v1, v2))), (-0.3, sgn(v2)), (1.0, force)),
        ]
        two = equations(rows, ("v1", "v2"), ("F",))
        t = np.linspace(0.0, 20.0, 2001)
        u = 3 * np.sin(t)
        x = simulate(two, [0.0, 0.0], t, u)
        predicted, index = simulate_windows(two, x, t, u, window=200)
        np.testing.assert_allclose(predicted, x[index], atol=5e-3)

    def test_several_models_at_once_equal_one_after_the_other(self, record):
        t, u, x = record
        rig = duffing()
        batch = np.stack([rig.coef, rig.coef * [[1.0], [0.9]], rig.coef * [[1.0], [1.2]]])
        together, _ = simulate_windows(rig, x, t, u, window=60, substeps=1, coef=batch)
        for coef, predicted in zip(batch, together, strict=True):
            alone = Equations(rig.terms, coef, rig.states, rig.inputs)
            single, _ = simulate_windows(alone, x, t, u, window=60, substeps=1)
            np.testing.assert_allclose(predicted, single, atol=1e-9)

    def test_input_sign_jumps_inside_windows(self):
        model = equations([sgn(variable(1))], ("x",), ("u",))
        t = np.arange(9.0)
        u = [0, 0, 1, 1, 0, 0, -1, 1, -1]
        x = np.array([0, 0, 1, 2, 3, 3, 2, 2, 2.0])[:, None]
        predicted, index = simulate_windows(model, x, t, u, window=4)
        np.testing.assert_allclose(predicted, x[index], atol=1e-9)

    def test_sign_inside_a_sign_is_followed(self):
        outer = sgn(add(constant(0.5), sgn(add(variable(0), variable(1)))))
        model = equations([total((-1.0, variable(0)), (1.1, outer))], ("x",), ("u",))
        t = np.linspace(0.0, 10.0, 1001)
        u = 3 * np.sin(2 * t)
        x = simulate(model, [1.0], t, u)
        predicted, index = simulate_windows(model, x, t, u, window=200)
        np.testing.assert_allclose(predicted, x[index], atol=1e-5)

    def test_windows_may_overlap(self, record):
        t, u, x = record
        _, index = simulate_windows(duffing(), x, t, u, window=100, stride=50)
        assert index[1, 0] == 51


class TestErrors:
    t = np.linspace(0.0, 1.0, 11)

    @pytest.mark.parametrize(
        ("changed", "match"),
        [
            ({"x0": [0.0]}, r"simulate\(x0=...\) must hold 2 values, one for each of q, v; got"),
            ({"x0": [0.0, np.nan]}, r"simulate\(x0=...\) must be finite; got nan at \(1,\)"),
            (
                {"t": np.zeros(11)},
                r"simulate\(t=...\) must be strictly increasing; got a step of 0",
            ),
            ({"t": [0.0]}, r"simulate\(t=...\) must be a 1-D array of at least 2 times"),
            ({"u": None}, r"simulate\(u=...\) must be given: the equations have the inputs F"),
            ({"u": np.zeros(10)}, r"simulate\(u=...\) must have shape \(11, 1\); got \(10, 1\)"),
            ({"u": np.zeros((11, 2))}, r"must have shape \(11, 1\); got \(11, 2\)"),
            ({"u": np.full(11, np.inf)}, r"simulate\(u=...\) must be finite; got inf at \(0,\)"),
            ({"substeps": 0}, r"simulate\(substeps=...\) must be an integer of at least 1"),
            ({"tolerance": -1.0}, r"simulate\(tolerance=...\) must be above 0"),
            ({"on_divergence": "ignore"}, r"simulate\(on_divergence=...\) must be"),
        ],
    )
    def test_bad_values_are_named(self, changed, match):
        given = {"x0": [0.0, 0.0], "t": self.t, "u": np.zeros(11), **changed}
        with pytest.raises(ValueError, match=match):
            simulate(block(), **given)

    def test_input_of_equations_without_inputs_is_refused(self):
        with pytest.raises(ValueError, match="Leave u out"):
            simulate(block(inputs=()), [0.0, 0.0], self.t, np.zeros(11))

    def test_text_is_no_number(self):
        with pytest.raises(TypeError, match=r"simulate\(x0=...\) must be an array of numbers"):
            simulate(block(), ["a", "b"], self.t, self.t)

    def test_something_else_is_no_model(self):
        with pytest.raises(TypeError, match=r"simulate\(model=...\) must be a fitted SINDy model"):
            simulate(3.0, [0.0], self.t)

    @pytest.mark.parametrize(
        ("changed", "match"),
        [
            ({"window": 11}, r"simulate_windows\(window=...\) must be below the 11 samples"),
            ({"window": 0}, r"simulate_windows\(window=...\) must be an integer of at least 1"),
            ({"stride": -1}, r"simulate_windows\(stride=...\) must be an integer of at least 1"),
            ({"x": np.zeros((11, 3))}, r"simulate_windows\(x=...\) must have shape \(11, 2\)"),
            ({"coef": np.zeros((2, 2))}, r"simulate_windows\(coef=...\) must have shape"),
        ],
    )
    def test_bad_windows_are_named(self, changed, match):
        given = {"x": np.zeros((11, 2)), "t": self.t, "u": np.zeros(11), "window": 5, **changed}
        with pytest.raises(ValueError, match=match):
            simulate_windows(block(), **given)


def test_a_root_of_the_speed_beside_its_sign_is_followed_through_zero() -> None:
    q, v = variable(0), variable(1)
    root = call(BUILTIN["sqrt"], call(BUILTIN["abs"], v))
    drag = mul(root, call(BUILTIN["sgn"], v))
    t = np.arange(0.0, 3.0, 0.01)
    system = equations([v, total((-20.0, q), (-0.6, v), (-1.0, drag))], ("q", "v"))
    run = simulate(system, [0.1, 0.0], t)

    def rates(_: float, x: np.ndarray) -> list[float]:
        drag = np.sqrt(abs(x[1])) * np.sign(x[1])
        return [x[1], -20 * x[0] - 0.6 * x[1] - drag]

    reference = solve_ivp(rates, (0.0, 3.0), [0.1, 0.0], t_eval=t, max_step=1e-3).y.T
    np.testing.assert_allclose(run, reference, atol=2e-4)
