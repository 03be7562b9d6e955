"""Of two poles in a row no record tells which is the lag's."""

from types import SimpleNamespace

import numpy as np
import pytest
from loop_systems import equations_of
from scipy.signal import lfilter

import pysindy_evolve as pse
from pysindy_evolve.hidden_states.memory import LAG, Memory
from pysindy_evolve.hidden_states.memory_equations import with_memories
from pysindy_evolve.loop.report.exchangeable_poles import exchangeable_poles


def steered(bend: float, seed: int = 0) -> pse.Record:
    """Simulate a ship whose rudder lags by 2 s, and that turns within 8 s, or harder when fast."""
    rng, dt, n, parts = np.random.default_rng(seed), 0.5, 800, 20
    wanted = np.repeat(rng.choice([-0.3, -0.15, 0.0, 0.15, 0.3], n // 24 + 1), 24)[:n]
    fine = np.repeat(wanted, parts)
    share = 1.0 - np.exp(-dt / parts / 2.0)
    rudder = lfilter([0.0, share], [1.0, share - 1.0], fine)
    rate = np.zeros(n * parts)
    for k in range(n * parts - 1):
        own = -0.12 * rate[k] - bend * abs(rate[k]) * rate[k]
        rate[k + 1] = rate[k] + dt / parts * (own + 0.1 * rudder[k])
    shown = rate[::parts] + 0.002 * rng.standard_normal(n)
    return pse.prepare(dt * np.arange(n), shown, wanted, order=1, held=True)


TWO_INPUTS = ("d", "w")


@pytest.mark.parametrize(
    ("sides", "is_said"),
    [
        ({"r": "-0.5*r + 0.4*d + 1"}, True),
        ({"r": "-0.5*r + 0.4*d", "q": "r - 2*q"}, True),
        ({"r": "0.5*r + 0.4*d"}, False),
        ({"r": "-0.5*r**3 + 0.4*d"}, False),
        ({"r": "-0.5*r + 0.4*d + w"}, False),  # which does not go through the lag
        ({"r": "-0.5*r + 0.4*d + q", "q": "-2*q"}, False),
        ({"r": "-0.5*r + 0.4*d", "q": "d - 2*q"}, False),
    ],
)
def test_nothing_else_may_act_on_the_state_nor_the_input_elsewhere(sides, is_said):
    model = with_memories(equations_of(sides, TWO_INPUTS), (Memory(LAG, 0, (8.0,)),))
    said = exchangeable_poles(SimpleNamespace(after=SimpleNamespace(model=model)))
    assert len(said) == is_said
    assert all("the lag, 8, and that of r itself, 2, can change places" in one for one in said)


@pytest.mark.slow
@pytest.mark.parametrize(("bend", "side"), [(0.0, "-a*r + k*d"), (1.0, "-a*r - b*r*abs(r) + k*d")])
def test_a_lag_and_the_state_that_it_acts_on_may_change_places_if_both_are_linear(bend, side):
    ship = pse.DeclaredModel({"r": side}, inputs=["d"])
    report = pse.close_loop(ship, steered(bend), operators=(), n_twins=59, random_state=0)
    (effect,) = report.effects
    assert effect.name == "actuator lag"
    said = str(report).replace("\n", " ")
    assert ("can change places" in said) is (bend == 0.0)
    if bend == 0.0:
        own = 1.0 / report.after.parameters["a"]
        constants = sorted([float(effect.coefficients[0]), own])
        assert constants == pytest.approx([2.0, 8.3], rel=0.1)
        assert f"that of r itself, {own:.4g}," in said
