"""A mass that nobody measured swings behind one that was: how it is found, and where it is not."""

import numpy as np
import pytest
from loop_systems import multisine
from scipy.integrate import solve_ivp

import pysindy_evolve as pse
from pysindy_evolve.hidden_states.flexible_mode import flexible_mode
from pysindy_evolve.loop.effects.flexible_modes import flexible_ways, within_band
from pysindy_evolve.terms import variable

DECLARED = pse.DeclaredModel({"q": "v", "v": "-k*q - c*v + b*F"}, inputs=["F"])
FREQUENCY, DAMPING = 24.0, 0.025


def measured(ratio=0.5, noise=0.001, seed=3, *, duration=12.0, cubic=0.0):
    """Measure a mass with another one behind it, of so many times its mass."""
    t, force = np.arange(0.0, duration, 0.002), multisine(20.0, seed, band=(0.5, 12.0))
    pushed = force(t)

    def rate(now, x):
        q, v, h, w = x
        pull = FREQUENCY**2 * (q - h) + 2.0 * DAMPING * FREQUENCY * (v - w)
        own = np.interp(now, t, pushed) - 40.0 * q - 3.0 * v - cubic * q**3
        return [v, own - ratio * pull, w, pull]

    options = {"t_eval": t, "max_step": 0.004, "rtol": 1e-7, "atol": 1e-10}
    q = solve_ivp(rate, (0.0, t[-1]), [0.0] * 4, **options).y[0]
    q = q + noise * q.std() * np.random.default_rng(seed).standard_normal(len(t))
    return pse.prepare(t, q, pushed)


def numbers_in(report):
    (path,) = report.equations.paths
    return [float(path.args[k].evaluate(np.empty((1, 0)))[0]) for k in (3, 4)]


def test_frequencies_lie_within_what_a_filter_leaves():
    record = measured(duration=6.0)
    ways = flexible_ways(1, 0, record)
    made = [way.shape.values[0] for way in ways]
    assert made[0] == pytest.approx(2 * np.pi * 16 / (len(record) * record.dt))
    assert made[-1] < 2 * np.pi * 0.5 * record.preparation.cutoff
    inside, outside = (
        flexible_mode(variable(0), variable(1), variable(3), f, DAMPING).parts[0][1].factors[0][0]
        for f in (FREQUENCY, 1.01 * made[0])
    )
    assert within_band(inside, record)
    assert not within_band(outside, record)


@pytest.mark.slow
@pytest.mark.parametrize(("ratio", "noise"), [(0.5, 0.001), (0.1, 0.005)])
def test_mass_behind_a_spring_is_found_with_its_numbers(ratio, noise):
    records = measured(ratio, noise), measured(ratio, noise, seed=4)
    report = pse.close_loop(DECLARED, records[0], records[1], operators=(), random_state=0)
    (effect,) = report.effects
    assert effect.name == "hidden state"
    assert -effect.coefficients[0] == pytest.approx(ratio * FREQUENCY**2, rel=0.03)
    assert numbers_in(report) == pytest.approx([FREQUENCY, DAMPING], rel=0.1)
    assert report.after.parameters["k"] == pytest.approx(40.0, rel=0.1)
    assert report.after.simulation_error[0] < 100.0 * noise + 1.0
    assert report.model.feature_names == ["q", "v", "q_mode", "v_mode", "F"]
    assert report.simulate(records[1]).shape == (len(records[1]), 4)
    assert "q_mode: swings at 2" in str(report)
    assert "v_mode" in pse.to_code(report.model, language="c")


@pytest.mark.slow
def test_stiffening_spring_is_no_mass_behind_one():
    report = pse.close_loop(DECLARED, measured(0.0, cubic=400.0), operators=(), random_state=0)
    assert [effect.name for effect in report.effects] == ["cubic stiffness"]
