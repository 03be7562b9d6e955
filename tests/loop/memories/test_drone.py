"""A rotor that lags and a drag, both missing in a closed loop: what each looks like alone."""

import numpy as np
import pytest

import pysindy_evolve as pse

DT, STEPS = 0.01, 4000
DRAG, LAG, GRAVITY = 0.25, 0.05, 9.81


def flight(seed):
    """Measure the height of a drone under control, and the thrust that is asked for: t, z, T."""
    rng = np.random.default_rng(seed)
    t = DT * np.arange(STEPS)
    rates, phases = rng.uniform(0.05, 0.8, 8), rng.uniform(0.0, 2.0 * np.pi, 8)
    wanted = 0.6 * np.sin(2.0 * np.pi * np.outer(t, rates) + phases).sum(axis=1)
    state, z, asked = np.array([0.0, 0.0, GRAVITY]), np.zeros(STEPS), np.zeros(STEPS)
    for k in range(STEPS):
        place, speed = state[:2] + rng.normal(0.0, [0.005, 0.02])
        thrust = np.clip(GRAVITY + 8.0 * (wanted[k] - place) - 4.0 * speed, 0.0, 25.0)
        z[k], asked[k] = state[0], thrust
        for _ in range(3):
            state = _moved(state, thrust, DT / 3.0)
    return t, z + 0.002 * z.std() * rng.standard_normal(STEPS), asked


def _moved(state, thrust, dt):
    """Take one step of the classical scheme of Runge and Kutta."""

    def rate(x):
        drag = DRAG * x[1] * abs(x[1])
        return np.array([x[1], x[2] - GRAVITY - drag, (thrust - x[2]) / LAG])

    a = rate(state)
    b = rate(state + 0.5 * dt * a)
    c = rate(state + 0.5 * dt * b)
    d = rate(state + dt * c)
    return state + dt / 6.0 * (a + 2.0 * b + 2.0 * c + d)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 3])
def test_a_lag_is_no_delay_once_the_drag_is_known(seed):
    """Beside a model without the drag, a delay does as well, and takes its part of it."""
    t, z, asked = flight(seed)
    model = pse.DeclaredModel({"z": "v", "v": "b*T - g"}, inputs=["T"])
    report = pse.close_loop(model, pse.prepare(t, z, asked, held=True), random_state=0)
    found = {effect.name: effect.coefficients[0] for effect in report.effects}
    assert found == pytest.approx({"actuator lag": LAG, "quadratic drag": -DRAG}, rel=0.05)
    assert report.after.parameters == pytest.approx({"b": 1.0, "g": GRAVITY}, rel=0.01)
