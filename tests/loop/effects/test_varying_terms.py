"""What a declared term is worth may change with a state or an input, and is found where it does."""

import numpy as np
import pytest

import pysindy_evolve as pse
from pysindy_evolve.loop.effects.candidate import OFFSET, Candidate
from pysindy_evolve.loop.effects.missing import candidates
from pysindy_evolve.loop.effects.varying_terms import hyperbolas
from pysindy_evolve.loop.given.ranges import Ranges
from pysindy_evolve.terms import mul, power, variable

CURRENTS = {"i": "b*u - r*i", "T": "c*u**2 - h*(T - Ta)"}


def varying_in(sides, inputs):
    design = pse.DeclaredModel(sides, inputs=inputs).design()
    names = (*design.states, *design.inputs, "t")
    offered = candidates(design, Ranges.about_zero(np.full(len(names), 3.0)))
    return {(c.state, c.terms[0].name(names)): c for c in offered if c.never_paired and c.parents}


def test_each_term_may_change_with_each_state_and_input_and_needs_the_term_beside_it():
    found = varying_in(CURRENTS, ("u", "Ta"))
    assert {name for state, name in found if state == 0} == {"T u", "u Ta"}
    by_temperature = found[0, "T u"]
    assert by_temperature.parents == (OFFSET, variable(2))
    assert by_temperature.never_paired


def test_the_product_of_a_state_and_an_input_keeps_the_name_it_has():
    assert (0, "i u") not in varying_in(CURRENTS, ("u", "Ta"))


def test_what_changes_with_the_time_is_no_input_gain_as_the_time_is_no_input():
    pumped = {"I": "b*S*I - g*I + p*I*cos(6.28*t) + d*I*t"}
    found = varying_in(pumped, ("S",))
    named = {name: candidate.name for (_, name), candidate in found.items()}
    assert named["I S cos(6.28 t)"] == "periodic forcing"
    assert named["I S t"] == "drift"
    assert named["I S^2"] == "input gain"


def heated(loss, seed, noise=2e-3):
    """A heater with a fan: temperature above the room, driven by heat u and fan speed w."""
    t, rng = np.arange(0.0, 40.0, 0.04), np.random.default_rng(seed)
    steps = [rng.uniform(0.0, 1.0, (8, 2)) for _ in range(2)]
    u = np.column_stack([
        np.interp(t, np.linspace(0.0, 40.0, 8), 10.0 * steps[0][:, 0]),
        np.interp(t, np.linspace(0.0, 40.0, 8), steps[1][:, 1]),
    ])  # fmt: skip
    model = pse.DeclaredModel({"T": f"2*u {loss}"}, inputs=["u", "w"]).design().equations([])
    x = pse.simulate(model, [5.0], t, u)
    y = x + noise * x.std() * rng.standard_normal(x.shape)
    return pse.prepare(t, y, u, order=1)


@pytest.mark.slow
@pytest.mark.parametrize(("loss", "found"), [("- 0.4*T - 0.5*T*w", ["T*w"]), ("- 0.4*T", [])])
def test_a_fan_that_cools_better_the_faster_it_turns(loss, found):
    records = [heated(loss, seed) for seed in range(3)]
    declared = pse.DeclaredModel({"T": "b*u - h*T"}, inputs=["u", "w"])
    report = pse.close_loop(declared, records[:2], records[2], operators=(), random_state=0)
    assert [str(effect.term) for effect in report.effects] == found


def test_a_hyperbola_takes_the_place_of_a_term_times_another_variable_only():
    """Beside the declared term it begins as that product."""
    design = pse.DeclaredModel({"q": "v", "v": "-k*q - c*v"}).design()
    ranges = Ranges.about_zero(np.full(3, 2.0))
    q, v = variable(0), variable(1)
    square, cube, varying = (Candidate("any", 1, (mul(q, x),)) for x in (q, power(q, 2), v))
    assert hyperbolas(square, design, ranges) == hyperbolas(cube, design, ranges) == []
    rows = np.random.default_rng(0).uniform(-2.0, 2.0, (50, 3))
    damped = pse.DeclaredModel({"q": "v", "v": "-c*v"}).design()
    found = hyperbolas(varying, damped, ranges)
    assert {one.branch for one in found} == {-2, -1, 1, 2}
    for one in found:
        assert min(one.shape.values) * np.exp(-one.shape.reach) > 2.0  # no pole in the range
    near, far = found[0].at([2.5]), found[-1].at([2.5])
    wanted = rows[:, 1] / (2.5 - rows[:, 0]), rows[:, 1] / (2.5 + rows[:, 0]) ** 2
    assert near.terms[0].evaluate(rows) == pytest.approx(wanted[0])
    assert far.terms[0].evaluate(rows) == pytest.approx(wanted[1])
