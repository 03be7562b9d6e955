"""What no tried effect explains is seen all the same: the verdict "untraced"."""

import numpy as np
import pytest
from loop_systems import levitated
from scipy.integrate import solve_ivp
from scipy.signal import lfilter

import pysindy_evolve as pse
from pysindy_evolve.signals.noise import input_noise

DECLARED = pse.DeclaredModel({"q": "v", "v": "-k*q - c*v + b*u"}, inputs=["u"])


def measured(strength):
    """Simulate an oscillator whose damping an input changes with the position."""
    t = np.arange(0.0, 40.0, 0.02)

    def u(s):
        return np.sin(1.3 * s) + 0.7 * np.sin(2.9 * s + 1.0)

    def rates(s, x):
        q, v = x
        return v, -4.0 * q - 0.4 * v + 3.0 * u(s) - strength * q * v * u(s)

    solution = solve_ivp(rates, (0.0, t[-1]), (0.5, 0.0), t_eval=t, rtol=1e-8, atol=1e-9)
    noise = 1e-3 * np.random.default_rng(0).standard_normal(len(t))
    return pse.prepare(t, solution.y[0] + noise, u(t))


@pytest.mark.slow
@pytest.mark.parametrize(("strength", "verdict"), [(0.15, "untraced"), (0.0, "complete")])
def test_structure_that_no_tried_effect_explains_is_said_to_be_there(strength, verdict):
    report = pse.close_loop(DECLARED, measured(strength), operators=(), random_state=0)
    assert report.verdict == verdict, str(report)


def motor(friction):
    """Current and speed of a motor under three waves of voltage, as noisy sensors read them."""
    t = np.arange(0.0, 8.0, 0.005)

    def u(s):
        return 6.0 * np.sin(1.1 * s) + 4.0 * np.sin(3.7 * s + 1.0) + 2.0 * np.sin(9.0 * s + 2.0)

    def rates(s, x):
        i, w = x
        rubbed = friction * np.tanh(w / 1e-3)
        return (u(s) - 1.2 * i - 0.5 * w) / 0.05, (0.5 * i - 0.05 * w - rubbed) / 0.02

    solution = solve_ivp(
        rates, (0.0, t[-1]), (0.0, 0.0), t_eval=t, method="LSODA", rtol=1e-8, atol=1e-9
    )
    y = solution.y.T
    noise = 3e-3 * y.std(axis=0) * np.random.default_rng(0).standard_normal(y.shape)
    return pse.prepare(t, y + noise, u(t), order=1)


@pytest.mark.parametrize(("friction", "verdict"), [(0.1, "untraced"), (0.0, "complete")])
def test_where_no_effect_is_looked_for_one_that_is_missing_is_structure(friction, verdict):
    """A polynomial of four variables in two equations fits more noise than the friction is."""
    declared = pse.DeclaredModel({"i": "a*u - r*i - k*w", "w": "m*i - d*w"}, inputs=["u"])
    report = pse.close_loop(declared, motor(friction), max_effects=0, random_state=0)
    assert report.verdict == verdict, str(report)


@pytest.mark.slow
def test_a_grown_term_explains_it():
    report = pse.close_loop(DECLARED, measured(0.15), n_twins=59, random_state=0)
    assert [effect.name for effect in report.effects] == ["evolved term"], str(report)
    assert str(report.effects[0].term) in {"q*u*v", "q*v*u"}


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 4])
def test_an_input_that_answers_the_noise_of_the_sensor_is_no_structure(seed):
    declared = pse.DeclaredModel({"z": "v", "v": "g - C*i**2/z**2"}, inputs=["i"])
    report = pse.close_loop(declared, levitated(seed), operators=(), random_state=0)
    assert report.verdict == "complete", str(report)


@pytest.mark.slow
def test_colored_noise_of_the_sensors_of_three_states_is_no_structure():
    """A heater warms one body, and that the next ones; noise is remembered over five samples."""
    rng, t = np.random.default_rng(1), 2.0 * np.arange(8000)
    power = np.interp(t, 200.0 * np.arange(81), rng.uniform(0.0, 50.0, 81))
    rates = {"A": "0.02*P - 0.05*(A - B)", "B": "0.03*(A - B) - 0.02*(B - C)"}
    model = pse.DeclaredModel({**rates, "C": "0.02*(B - C) - 0.01*(C - 20)"}, inputs=["P"])
    x = pse.simulate(model.design().equations([]), [20.0] * 3, t, power)
    white = rng.standard_normal(x.shape)
    colored = lfilter([0.6], [1.0, -0.8], white, axis=0)
    record = pse.prepare(t, x + 1.5e-3 * x.std(axis=0) * colored, power, order=1)
    equations = {"A": "a*P - b*(A - B)", "B": "c*(A - B) - d*(B - C)"}
    declared = pse.DeclaredModel({**equations, "C": "e*(B - C) - h*(C - 20)"}, inputs=["P"])
    report = pse.close_loop(declared, record, random_state=0)
    assert report.verdict == "complete", str(report)


@pytest.mark.parametrize(("force", "found"), [(0.4, ["periodic forcing"]), (0.0, [])])
def test_a_forcing_with_five_periods_in_the_record_is_found(force, found):
    t = np.arange(0.0, 20.0, 0.01)
    solution = solve_ivp(
        lambda s, x: -0.7 * x + 1.0 + force * np.sin(2.2 * s),
        (0.0, t[-1]), (0.0,), t_eval=t, rtol=1e-9, atol=1e-10,
    )  # fmt: skip
    noise = 1e-3 * np.random.default_rng(0).standard_normal(len(t))
    record = pse.prepare(t, solution.y[0] + noise, order=1)
    report = pse.close_loop(pse.DeclaredModel({"T": "-a*T + b"}), record, random_state=0)
    assert [effect.name for effect in report.effects] == found, str(report)
    assert report.verdict == ("traced" if found else "complete")


def coil(noise, n=6000, dt=0.005):
    """Current of a coil, exactly as sampled, and its voltage as a noisy sensor reads it."""
    t, rng = dt * np.arange(n), np.random.default_rng(3)
    lines, phases = np.linspace(0.2, 12.0, 20), rng.uniform(0.0, 6.3, 20)
    waves = np.exp(1j * (2 * np.pi * np.outer(t, lines) + phases))
    answer = 1.0 / (0.05 * 2j * np.pi * lines + 1.2)
    current, voltage = (waves @ answer).imag, waves.imag.sum(axis=1)
    current = current + 0.002 * rng.standard_normal(n)
    return pse.prepare(t, current, voltage + noise * rng.standard_normal(n), order=1)


@pytest.mark.slow
def test_noise_of_the_sensor_of_an_input_is_no_structure():
    declared = pse.DeclaredModel({"i": "a*u - r*i"}, inputs=["u"])
    for noise in (0.0, 0.02, 0.1):
        report = pse.close_loop(declared, coil(noise), operators=(), random_state=0)
        assert report.verdict == "complete", str(report)


def test_an_input_that_is_held_has_no_noise_that_its_steps_could_be_taken_for():
    rng = np.random.default_rng(0)
    steps = np.repeat(rng.choice([-1.0, 1.0], 300), 20)
    noisy = steps + 0.02 * rng.standard_normal(6000)
    levels = input_noise(np.column_stack([steps, noisy]), 0.01, None)
    assert levels[0] == 0.0
    assert levels[1] >= 0.02


@pytest.mark.slow
def test_what_a_found_effect_leaves_is_said_to_depend_on_what_was_measured():
    record = measured(0.15)
    declared = pse.DeclaredModel({"q": "v", "v": "-k*q + b*u"}, inputs=["u"])
    report = pse.close_loop(declared, record, operators=(), random_state=0)
    assert [effect.name for effect in report.effects] == ["viscous damping"]
    assert report.chance_left < 0.02
    assert "still depends on what was measured" in str(report)
    clean = pse.close_loop(declared, measured(0.0), operators=(), random_state=0)
    assert clean.verdict == "traced"
    assert "still depends on what was measured" not in str(clean)
