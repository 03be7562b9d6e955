"""What no tried effect explains is seen all the same: the verdict "untraced"."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import pysindy_evolve as pse

DECLARED = pse.DeclaredModel({"q": "v", "v": "-k*q - c*v + b*u"}, inputs=["u"])


def measured(strength):
    """Simulate an oscillator whose damping an input changes with the position."""
    t = np.arange(0.0, 60.0, 0.02)

    def u(s):
        return np.sin(1.3 * s) + 0.7 * np.sin(2.9 * s + 1.0)

    def rates(s, x):
        q, v = x
        return v, -4.0 * q - 0.4 * v + 3.0 * u(s) - strength * q * v * u(s)

    solution = solve_ivp(rates, (0.0, t[-1]), (0.5, 0.0), t_eval=t, rtol=1e-8, atol=1e-9)
    noise = 1e-3 * np.random.default_rng(0).standard_normal(len(t))
    return pse.prepare(t, solution.y[0] + noise, u(t))


@pytest.mark.parametrize(("strength", "verdict"), [(0.15, "untraced"), (0.0, "complete")])
def test_structure_that_no_tried_effect_explains_is_said_to_be_there(strength, verdict):
    report = pse.close_loop(DECLARED, measured(strength), operators=(), random_state=0)
    assert report.verdict == verdict, str(report)


def test_a_grown_term_explains_it():
    report = pse.close_loop(DECLARED, measured(0.15), random_state=0)
    assert [effect.name for effect in report.effects] == ["evolved term"], str(report)
    assert str(report.effects[0].term) in {"q*u*v", "q*v*u"}


def levitated(seed, n=20_000, dt=1e-3, noise=2e-6):
    """A magnet that a current holds, controlled by what a noisy sensor shows; nothing missing."""
    rng = np.random.default_rng(seed)
    t = dt * np.arange(n)
    waves = np.sin(2 * np.pi * np.outer(t, np.linspace(0.2, 4.0, 25)) + rng.uniform(0, 6.3, 25))
    target = 0.01 + 6e-4 * waves.sum(axis=1) / waves.sum(axis=1).std()
    z, v, slope, before, current = 0.01, 0.0, 0.0, 0.01, 1.0
    shown, applied = np.empty(n), np.empty(n)
    for k in range(n):
        shown[k], applied[k] = z + noise * rng.standard_normal(), current
        slope += 0.3 * ((shown[k] - before) / dt - slope)
        before = shown[k]
        after = min(max(1.0 + 250.0 * (before - target[k]) + 6.0 * slope, 0.1), 3.0)
        for part in (0.125, 0.375, 0.625, 0.875):  # the current is straight between samples
            i = current + part * (after - current)
            middle = z + 0.125 * dt * v
            pull = 9.81 - 9.81e-4 * i**2 / middle**2
            z, v = z + 0.25 * dt * v + pull * dt**2 / 32.0, v + 0.25 * dt * pull
        current = after
    return pse.prepare(t, shown, applied)


@pytest.mark.parametrize("seed", [1, 4])
def test_an_input_that_answers_the_noise_of_the_sensor_is_no_structure(seed):
    declared = pse.DeclaredModel({"z": "v", "v": "g - C*i**2/z**2"}, inputs=["i"])
    report = pse.close_loop(declared, levitated(seed), operators=(), random_state=0)
    assert report.verdict == "complete", str(report)
