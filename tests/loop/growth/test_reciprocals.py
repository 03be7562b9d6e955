"""What acts the less the larger a variable is."""

import numpy as np
import pytest

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
    report = pse.close_loop(QUADROTOR, quadrotor(100), quadrotor(101), random_state=0)
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
