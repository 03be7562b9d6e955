"""Free runs of the friction rig against scipy and against themselves."""

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from pysindy_evolve.equations import Equations
from pysindy_evolve.simulation import simulate

from .sliding_systems import duffing


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
