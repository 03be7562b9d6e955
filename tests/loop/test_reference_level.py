"""A loss to a reference level, k (p - p0), is found with its level and not as its slope alone."""

import numpy as np
import pytest

import pysindy_evolve as pse

LEAK, AMBIENT = 0.01, 101325.0


def vessel(seed, dt=0.02, duration=60.0):
    """An air vessel that leaks to the ambient, filled by a mass flow that is held for 2 s."""
    rng = np.random.default_rng(seed)
    t = dt * np.arange(round(duration / dt))
    flow = np.repeat(rng.uniform(-3e-4, 1e-3, len(t) // 100), 100)
    gain, decay = 287.0 * 293.0 / 0.01, np.exp(-LEAK * dt)
    p = np.empty(len(t))
    p[0] = 3e5
    for k in range(len(t) - 1):  # exact for an input that is held
        rest = AMBIENT + gain * flow[k] / LEAK
        p[k + 1] = rest + (p[k] - rest) * decay
    noisy = p + 300.0 * rng.standard_normal(len(t))
    return pse.prepare(t, noisy, flow + 2e-6 * rng.standard_normal(len(t)), order=1)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 4])  # in 4 a grown term would come first
def test_a_leak_to_the_ambient_has_its_pressure(seed):
    declared = pse.DeclaredModel({"p": "b*mdot"}, inputs=["mdot"])
    report = pse.close_loop(declared, vessel(seed), vessel(2), random_state=0)
    found = {effect.name: float(effect.coefficients[0]) for effect in report.effects}
    assert found["viscous damping"] == pytest.approx(-LEAK, rel=0.15), str(report)
    assert found["constant offset"] == pytest.approx(LEAK * AMBIENT, rel=0.15)
    assert report.after.simulation_error[0] < 2.0


def cooled(seed, dt=0.01, every=10, duration=150.0):
    """A cooled tank in kelvin that loses heat to a room of 295 K, which nobody declared."""
    rng = np.random.default_rng(seed)
    t = dt * np.arange(round(duration / dt))
    lines = np.linspace(0.01, 0.5, 15)
    phases = rng.uniform(0.0, 6.3, (2, 15, 1))
    waves = np.sin(2 * np.pi * np.outer(lines, t) + phases).sum(axis=1)
    u = np.array([[300.0], [40.0]]) + np.array([[1.5], [3.0]]) * waves
    temperature, slope = np.full(len(t), 325.0), -3.15
    for k in range(len(t) - 1):
        x, (coolant, heat) = temperature[k], u[:, k : k + 2].mean(axis=1)
        rate = 350.0 - x + heat + 2.1 * (coolant - x) - 0.05 * (x - 295.0)
        temperature[k + 1] = x + rate * np.expm1(slope * dt) / slope
    noisy = temperature[::every] + 0.01 * rng.standard_normal(len(t) // every)
    return pse.prepare(t[::every], noisy, u.T[::every], order=1)


@pytest.mark.slow
def test_a_leak_is_found_beside_a_known_constant():
    declared = pse.DeclaredModel({"T": "350 - T + b*Q + UA*(Tc - T)"}, inputs=["Tc", "Q"])
    report = pse.close_loop(declared, cooled(1), cooled(2), operators=(), random_state=0)
    found = {effect.name: float(effect.coefficients[0]) for effect in report.effects}
    assert set(found) == {"viscous damping", "constant offset"}, str(report)
    assert found["viscous damping"] == pytest.approx(-0.05, rel=0.2)
    assert found["constant offset"] == pytest.approx(0.05 * 295.0, rel=0.2)
