"""What acts between two angles is found whatever turns they have made."""

import numpy as np
import pytest
from loop_systems import measured

import pysindy_evolve as pse
from pysindy_evolve.loop.effects.angles import is_wave_of, without_turns
from pysindy_evolve.operators import BUILTIN
from pysindy_evolve.terms import add, call, constant, mul, variable

ROTORS = {
    "a": "1 + 0.35*sin(b - a) + 0.35*sin(c - a)",
    "b": "1.9 + 0.35*sin(a - b) + 0.35*sin(c - b)",
    "c": "3.1 + 0.35*sin(a - c) + 0.35*sin(b - c)",
}
DECLARED = pse.DeclaredModel(
    {
        "a": "u + K*sin(b - a) + K*sin(c - a)",
        "b": "v + K*sin(a - b) + K*sin(c - b)",
        "c": "w + K*sin(a - c) + K*sin(b - c)",
    }
)


def records_of(rates):
    """Three oscillators that run away from each other, three times."""
    model, t = pse.DeclaredModel(rates).design().equations([]), np.linspace(0.0, 25.0, 1000)
    rng, records = np.random.default_rng(0), []
    for _ in range(3):
        x = pse.simulate(model, list(rng.uniform(-3.0, 3.0, 3)), t, tolerance=1e-9)
        y = x + 2e-3 * rng.standard_normal(x.shape)
        records.append(pse.prepare(t, y, order=1))
    return records


@pytest.mark.slow
@pytest.mark.parametrize("harmonic", ["", " + 0.1*sin(2*b - 2*a)"])
def test_a_second_harmonic_of_a_coupling_is_found_where_it_is(harmonic):
    records = records_of(ROTORS | {"a": ROTORS["a"] + harmonic})
    report = pse.close_loop(DECLARED, records[:2], records[2], operators=(), random_state=0)
    found = [(e.name, e.state, str(e.term).lstrip("-")) for e in report.effects]
    assert found == ([("coupling", "a", "sin(2*a - 2*b)")] if harmonic else [])
    if harmonic:
        assert abs(report.effects[0].coefficients[0]) == pytest.approx(0.1, rel=0.02)


@pytest.mark.slow
@pytest.mark.parametrize("torque", ["", " + 4*sin(2*q - 0.6)"])
def test_what_comes_twice_a_turn_is_one_effect_wherever_the_angle_is_measured_from(torque):
    record = measured({"q": "v", "v": f"-0.8*v + F{torque}"}, size=12.0, duration=20.0)
    declared = pse.DeclaredModel({"q": "v", "v": "-c*v + b*F"}, inputs=["F"])
    report = pse.close_loop(declared, record, operators=(), random_state=0)
    assert [effect.name for effect in report.effects] == ["second harmonic"] * bool(torque)
    if torque:
        expected = [4.0 * np.cos(0.6), -4.0 * np.sin(0.6)]
        assert report.effects[0].coefficients == pytest.approx(expected, rel=0.02)


GEARED = {  # an arm whose large gears make the inertias constant; the gears hold q2 by springs
    "q1": "w1",
    "w1": "3*F - 2*w1 - 6*q1 + 1.2*w1*w2*sin(q2)",
    "q2": "w2",
    "w2": "2*F - 3*w2 - 9*q2 + 12 - 4*cos(q2) - 0.8*w1^2*sin(q2)",
}


@pytest.mark.slow
def test_forces_between_two_geared_joints_are_found_one_by_one():
    declared = {
        "q1": "w1",
        "w1": "b1*F - d1*w1 - k1*q1",
        "q2": "w2",
        "w2": "b2*F - d2*w2 - k2*q2 + o - g*cos(q2)",
    }
    record = measured(GEARED, size=10.0, noise=1e-4)
    model = pse.DeclaredModel(declared, inputs=["F"])
    report = pse.close_loop(model, record, operators=(), n_twins=59, random_state=0)
    assert [effect.name for effect in report.effects] == ["coupling"] * 2
    found = {str(effect.term): effect.coefficients[0] for effect in report.effects}
    assert found == {
        "w1*w2*sin(q2)": pytest.approx(1.2, rel=0.02),
        "w1**2*sin(q2)": pytest.approx(-0.8, rel=0.02),
    }


def test_whole_turns_are_taken_out_of_a_phase():
    turned = wave("sin", add(variable(0), constant(261.452)))
    plain = without_turns(turned)
    q = np.linspace(-3.0, 3.0, 50)[:, None]
    assert np.abs(plain.constants).max() <= np.pi
    assert np.abs(plain.evaluate(q)) == pytest.approx(np.abs(turned.evaluate(q)), abs=1e-9)


def test_gravity_may_be_counted_from_anywhere_but_in_radians():
    q, v = variable(0), variable(1)
    assert is_wave_of(wave("sin", add(q, constant(0.7))), 0)
    assert not is_wave_of(wave("sin", mul(constant(2.0), q)), 0)
    assert not is_wave_of(wave("sin", add(q, v)), 0)
    assert not is_wave_of(wave("sin", q), 1)


def wave(function, argument):
    """Return a function of a sum as a product, whose sign is left to its coefficient."""
    ((_, product),) = call(BUILTIN[function], argument).parts
    return product
