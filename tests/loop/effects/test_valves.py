"""What a valve lets through goes with the root of the pressure over it."""

import numpy as np
import pytest
from loop_systems import equations_of, measured

import pysindy_evolve as pse
from pysindy_evolve.loop.effects.missing import candidates
from pysindy_evolve.loop.given.ranges import Ranges

VALVES = {
    "u*sqrt(abs(10 - p*sign(u)))": 10.0,  # the load of a cylinder, which may help the valve
    "u*sqrt(abs(6 + sign(u)*(6 - p)))": 12.0,  # a chamber that is filled and emptied
}


@pytest.mark.slow
@pytest.mark.parametrize(("flow", "supply"), VALVES.items())
def test_a_valve_lets_through_what_the_pressure_over_it_drives(flow, supply):
    rng, t = np.random.default_rng(1), 0.005 * np.arange(8000)
    waves = zip(rng.uniform(0.1, 1.5, 9), rng.uniform(0.0, 6.28, 9), strict=True)
    u = 0.6 * sum(np.sin(2.0 * np.pi * f * t + phase) for f, phase in waves)
    rest = 6.0 if supply == 12.0 else 0.0
    x = pse.simulate(
        equations_of({"p": f"3*{flow} - 2*(p - {rest})"}, ("u",)), [rest], t, u[:, None]
    )
    noise = 3e-3 * x.std() * rng.standard_normal(x.shape)
    record = pse.prepare(t, x + noise, u, order=1)
    declared = pse.DeclaredModel({"p": f"b*u - c*(p - {rest})"}, inputs=["u"])
    report = pse.close_loop(declared, record, random_state=0)
    (effect,) = report.effects
    assert effect.name == "valve flow"
    assert effect.numbers == pytest.approx({"supply pressure": supply}, rel=0.03)
    assert effect.coefficients == pytest.approx([3.0], rel=0.03)


def test_a_valve_lets_nothing_through_in_the_equation_of_a_velocity():
    spring = {"q": "v", "v": "u - k*q"}
    ranges = Ranges.about_zero(np.full(4, 3.0))
    offered = candidates(pse.DeclaredModel(spring, inputs=["u"]).design(), ranges)
    assert not [c for c in offered if c.shape and "supply pressure" in c.shape.meanings]


@pytest.mark.slow
def test_a_dead_zone_of_the_opening_stands_within_the_flow():
    """Outside of the root it left a third, and an offset and a gain were named beside it."""
    opening = "(F - (abs(F + 3) - abs(F - 3))/2)"
    record = measured({"p": f"0.5*{opening}*sqrt(100 - p) - 8*p"}, order=1)
    valve = pse.DeclaredModel({"p": "a*F*sqrt(100 - p) - l*p"}, inputs=["F"])
    report = pse.close_loop(valve, record, operators=(), n_twins=59, random_state=0)
    (effect,) = report.effects
    assert effect.name == "dead zone"
    assert effect.numbers == pytest.approx({"half width": 3.0}, rel=0.02)
    assert effect.coefficients == pytest.approx([-0.5], rel=0.02)
