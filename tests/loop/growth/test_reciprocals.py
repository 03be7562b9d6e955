"""What acts the less the larger a variable is."""

import numpy as np
import pytest
import sympy

import pysindy_evolve as pse


def tank(seed):
    """A level that a pump of constant power raises, the slower the higher it is."""
    rng, t = np.random.default_rng(seed), 0.1 * np.arange(2000)
    inflow = np.interp(t, np.arange(40) * 5.2, rng.uniform(0.5, 3.0, 40))
    model = pse.DeclaredModel({"x": "-0.3*x + 0.2*u + 0.25/x"}, inputs=["u"])
    x = pse.simulate(model.design().equations([]), [2.0], t, inflow, tolerance=1e-9)
    y = x + 5e-3 * x.std() * rng.standard_normal(x.shape)
    return pse.prepare(t, y, inflow, order=1)


@pytest.mark.slow
def test_a_reciprocal_grows():
    declared = pse.DeclaredModel({"x": "-a*x + b*u"}, inputs=["u"])
    report = pse.close_loop(declared, tank(100), tank(101), random_state=0)
    (effect,) = report.effects
    assert (effect.name, str(effect.term)) == ("evolved term", "1/x")
    assert effect.coefficients == pytest.approx([0.25], rel=0.02)


GROUND = "0.02*T*cos(a)/z**2"


def quadrotor(seed, effect=GROUND):
    """Height and tilt of a quadrotor in the plane, which controllers of both move about."""
    rng, t = np.random.default_rng(seed), 0.01 * np.arange(6000)
    height = np.interp(t, 1.7 * np.arange(37), 0.2 * 10.0 ** rng.uniform(size=37))
    tilt = np.interp(t, 1.1 * np.arange(56), rng.uniform(-0.5, 0.5, 56))
    thrust, moment = "(9.81 + 16*(r - z) - 7*v)", "(30*(p - a) - 8*w)"
    side = f"-9.81 + T*cos(a) - 0.3*v + {effect}".replace("T", thrust)
    flight = {"z": "v", "v": side, "a": "w", "w": f"{moment} - 0.2*w"}
    model = pse.DeclaredModel(flight, inputs=["r", "p"])
    wanted = np.column_stack([height, tilt])
    x = pse.simulate(model.design().equations([]), [1.0, 0, 0, 0], t, wanted, tolerance=1e-9)
    z, v, a, w = x.T
    u = np.column_stack([9.81 + 16 * (height - z) - 7 * v, 30 * (tilt - a) - 8 * w])
    y = x[:, ::2] + 3e-3 * x[:, ::2].std(axis=0) * rng.standard_normal((len(t), 2))
    return pse.prepare(t, y, u)


QUADROTOR = pse.DeclaredModel(
    {"z": "v", "v": "-g + b*T*cos(a) - c*v", "a": "w", "w": "m*M - d*w"}, inputs=["T", "M"]
)


@pytest.mark.slow
def test_the_ground_effect_of_a_thrust_grows_from_the_thrust():
    report = pse.close_loop(QUADROTOR, quadrotor(100), quadrotor(101), n_twins=59, random_state=0)
    (effect,) = report.effects
    assert (effect.name, effect.state) == ("evolved term", "v")
    assert str(effect.term) == "T*cos(a)/z**2"
    assert effect.coefficients == pytest.approx([0.02], rel=0.02)


@pytest.mark.slow
def test_nothing_grows_from_the_thrust_far_from_the_ground():
    records = quadrotor(102, "0"), quadrotor(103, "0")
    assert not pse.close_loop(QUADROTOR, *records, random_state=1).effects


def snap_through(seed):
    """A mass between two springs that lie flat in its middle and are too long for that, in mm."""
    rng, t = np.random.default_rng(seed), 0.005 * np.arange(6000)
    phases = rng.uniform(0.0, 2 * np.pi, 14)
    force = sum(
        np.sin(2 * np.pi * f * t + p)
        for f, p in zip(np.linspace(0.4, 3.0, 14), phases, strict=True)
    )
    side = "1300*F - 250*q + 3000*q/sqrt(100 + q**2) - 1.5*v"
    model = pse.DeclaredModel({"q": "v", "v": side}, inputs=["F"])
    x = pse.simulate(model.design().equations([]), [4.0, 0.0], t, 0.38 * force, tolerance=1e-9)
    return pse.prepare(t, x[:, 0] + 0.02 * rng.standard_normal(len(t)), 0.38 * force)


@pytest.mark.slow
def test_the_length_of_an_inclined_spring_grows_below_the_line():
    declared = pse.DeclaredModel({"q": "v", "v": "-k*q - c*v + b*F"}, inputs=["F"])
    report = pse.close_loop(declared, snap_through(100), snap_through(101), random_state=0)
    (effect,) = report.effects
    assert (effect.name, effect.state) == ("evolved term", "v")
    assert effect.numbers == {"inner constant": pytest.approx(100.0, rel=0.02)}
    assert effect.coefficients == pytest.approx([3000.0], rel=0.01)


def parts_of(record):
    """Cut a record in two: to fit, to judge."""
    n = int(0.7 * len(record))
    return record[:n], record[n:]


@pytest.mark.slow
def test_an_eddy_current_brake_grows():
    """Its drag rises with the speed and falls again: c v / (1 + (v / 0.6)^2)."""
    rng, t = np.random.default_rng(0), 0.01 * np.arange(6000)
    waves = zip(rng.uniform(0.1, 1.2, 6), rng.uniform(0.0, 2.0 * np.pi, 6), strict=True)
    force = sum(3.0 * np.sin(2.0 * np.pi * f * t + phase) for f, phase in waves)
    rig = {"q": "v", "v": "F - 9*q - 0.3*v - 3*v/(1 + v**2/0.36)"}
    model = pse.DeclaredModel(rig, inputs=["F"]).design().equations([])
    q = pse.simulate(model, [0.5, 0.0], t, force, tolerance=1e-9)[:, :1]
    record = pse.prepare(t, q + 2e-3 * q.std() * rng.standard_normal(q.shape), force)
    declared = pse.DeclaredModel({"q": "v", "v": "b*F - k*q - c*v"}, inputs=["F"])
    report = pse.close_loop(declared, *parts_of(record), random_state=0)
    (effect,) = report.effects
    (v,) = effect.term.free_symbols
    assert sympy.simplify(v / effect.term) - v**2 == pytest.approx(0.36, rel=0.05)
    assert effect.coefficients == pytest.approx([-1.08], rel=0.03)


@pytest.mark.slow
def test_a_reaction_that_is_declared_in_one_equation_is_known_in_the_other():
    """Chlorine dioxide, iodine and malonic acid oscillate; one loses what the other gains."""
    t = 0.01 * np.arange(4000)
    rates = {"x": "8.9 - x - 4*x*y/(1 + x**2)", "y": "1.4*x - 1.4*x*y/(1 + x**2)"}
    x = pse.simulate(pse.DeclaredModel(rates).design().equations([]), [0.2, 0.35], t)
    noise = 5e-3 * x.std(axis=0) * np.random.default_rng(0).standard_normal(x.shape)
    record = pse.prepare(t, x + noise, order=1)
    declared = pse.DeclaredModel({"x": "a - b*x", "y": "c*x - d*x*y/(1 + x**2)"})
    report = pse.close_loop(declared, *parts_of(record), random_state=0)
    (effect,) = report.effects
    assert (effect.state, str(effect.term)) == ("x", "x*y/(x**2 + 1)")
    assert effect.coefficients == pytest.approx([-4.0], rel=0.01)
