"""What a declared term is worth may change with a state or an input, and is found where it does."""

from dataclasses import replace

import numpy as np
import pytest
from loop_systems import equations_of

import pysindy_evolve as pse
from pysindy_evolve.loop.effects.candidate import OFFSET, Candidate
from pysindy_evolve.loop.effects.missing import candidates
from pysindy_evolve.loop.effects.names import SATURATING
from pysindy_evolve.loop.effects.varying import hyperbolas
from pysindy_evolve.loop.given.ranges import Ranges
from pysindy_evolve.terms import mul, power, sub, variable

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


def test_a_product_saturates_with_what_stays_above_zero_in_it():
    design = pse.DeclaredModel({"N": "r*N - g*(N - 1)*S", "S": "m*N*S - a*S"}).design()
    low, high = np.array([0.5, -1.0, 0.0]), np.array([2.0, 3.0, 9.0])
    ranges = Ranges.of(np.random.default_rng(0).uniform(low, high, (500, 3)))
    found = [c for c in candidates(design, ranges) if c.name == SATURATING]
    assert {(c.state, c.variables) for c in found} == {(s, frozenset({0, 1})) for s in (0, 1)}
    places = [c.shape.values[0] for c in found if c.state == 1]
    assert places == pytest.approx([0.6, 2.0, 6.0] * 2, rel=0.01)  # sated, and with hidden prey
    assert found[0].at([3.0]).terms[0].name(("N", "S", "t")) == "-S/(3 + N) + N S/(3 + N)"


def test_what_saturates_already_may_do_so_with_a_further_level():
    """Predators keep each other from their prey (Beddington and DeAngelis)."""
    sides = {"N": "r*N - g*N*P/(2 + 4*N)", "P": "e*N*P - m*P"}
    design = pse.DeclaredModel(sides).design()
    ranges = Ranges.of(np.random.default_rng(0).uniform(1.0, 3.0, (500, 3)))
    rates = {c.at([3.0]).terms[0] for c in candidates(design, ranges) if c.name == SATURATING}
    crowded = "N P/(3 + 6 N + P)"
    assert crowded in {term.name(("N", "P", "t")) for term in rates}


def test_what_hides_is_eaten_by_the_square_of_it_where_there_is_little():
    design = pse.DeclaredModel({"N": "r*N - g*N*P"}, inputs=["P"]).design()
    ranges = Ranges.of(np.random.default_rng(0).uniform(1.0, 3.0, (500, 3)))
    found = {c.at([2.0]).terms[0] for c in candidates(design, ranges) if c.name == SATURATING}
    assert "N^2 P/(4 + N^2)" in {term.name(("N", "P", "t")) for term in found}


def test_a_rate_may_go_by_what_there_is_for_each():
    """Cells share what they eat (Contois)."""
    design = pse.DeclaredModel({"X": "m*S*X - a*X", "S": "-y*S*X"}).design()
    ranges = Ranges.of(np.random.default_rng(0).uniform(1.0, 3.0, (500, 3)))
    found = {c.at([0.9]).terms[0] for c in candidates(design, ranges) if c.name == SATURATING}
    assert "X S/(0.9 X + S)" in {term.name(("X", "S", "t")) for term in found}


def test_too_much_of_what_a_rate_saturates_with_may_inhibit_it():
    """Haldane's rate: a poison to those who eat much of it."""
    design = pse.DeclaredModel({"X": "m*S*X/(1 + S) - a*X", "S": "-y*S*X/(1 + S)"}).design()
    ranges = Ranges.of(np.random.default_rng(0).uniform(1.0, 3.0, (500, 3)))
    found = [c.at([2.0]).terms[0] for c in candidates(design, ranges) if c.name == SATURATING]
    rows = np.random.default_rng(1).uniform(1.0, 3.0, (50, 3))
    x, s = rows[:, 0], rows[:, 1]
    wanted = s * x / (1.0 + s + (s / 2.0) ** 2)
    assert any(term.evaluate(rows) == pytest.approx(wanted) for term in found)


def test_a_hyperbola_takes_the_place_of_a_term_times_another_variable_only():
    """Beside the declared term it begins as that product."""
    design, scales = pse.DeclaredModel({"q": "v", "v": "-k*q - c*v"}).design(), np.full(3, 2.0)
    q, v = variable(0), variable(1)
    square, cube, varying = (Candidate("any", 1, (mul(q, x),)) for x in (q, power(q, 2), v))
    assert hyperbolas(square, design, scales) == hyperbolas(cube, design, scales) == []
    rows = np.random.default_rng(0).uniform(-2.0, 2.0, (50, 3))
    damped = pse.DeclaredModel({"q": "v", "v": "-c*v"}).design()
    found = hyperbolas(varying, damped, scales)
    assert {one.branch for one in found} == {-2, -1, 1, 2}
    for one in found:
        assert min(one.shape.values) * np.exp(-one.shape.reach) > 2.0  # no pole in the range
    near, far = found[0].at([2.5]), found[-1].at([2.5])
    wanted = rows[:, 1] / (2.5 - rows[:, 0]), rows[:, 1] / (2.5 + rows[:, 0]) ** 2
    assert near.terms[0].evaluate(rows) == pytest.approx(wanted[0])
    assert far.terms[0].evaluate(rows) == pytest.approx(wanted[1])


def test_no_force_saturates_so():
    design = pse.DeclaredModel({"q": "v", "v": "-k*q - c*q**2*v"}).design()
    ranges = Ranges.of(np.random.default_rng(0).uniform(1.0, 3.0, (500, 3)))
    assert not [c for c in candidates(design, ranges) if c.name == SATURATING]


@pytest.mark.slow
@pytest.mark.parametrize("compression", [0.2, 0.0])
def test_a_gain_that_is_compressed_in_two_equations_has_one_number(compression):
    t, rng = np.arange(0.0, 50.0, 0.02), np.random.default_rng(3)
    pump = 2.6 + 0.6 * np.sin(0.4 * t) + 0.5 * np.sin(1.1 * t + 1.0) + 0.4 * np.sin(2.7 * t)
    gain = f"(N - 1)*S/(1 + {compression}*S)"
    laser = {"N": f"J - 0.8*N - {gain}", "S": f"2.5*{gain} - 1.2*S + 0.05*N"}
    x = pse.simulate(equations_of(laser, ("J",)), [1.1, 1.0], t, pump)
    y = x + 0.004 * x.std(axis=0) * rng.standard_normal(x.shape)
    declared = {"N": "p*J - c*N - g*(N - 1)*S", "S": "m*(N - 1)*S - a*S + e*N"}
    model = pse.DeclaredModel(declared, inputs=["J"])
    report = pse.close_loop(model, pse.prepare(t, y, pump, order=1), operators=(), random_state=0)
    assert [e.name for e in report.effects] == [SATURATING] * (2 if compression else 0)
    for effect in report.effects:
        assert effect.numbers["half-saturation"] == pytest.approx(5.0, rel=0.1)


@pytest.mark.slow
def test_who_grows_by_what_it_eats_is_sated_in_both_equations():
    """A chemostat after Monod: each half alone is lost in what the other leaves."""
    t, rng = np.arange(0.0, 150.0, 0.05), np.random.default_rng(0)
    dilution = np.repeat(rng.uniform(0.1, 0.45, 25), 120)
    uptake = "0.9*S*X/(0.8 + S)"
    chemostat = {"X": f"{uptake} - D*X", "S": f"D*(5 - S) - 2*{uptake}"}
    x = pse.simulate(equations_of(chemostat, ("D",)), [1.0, 2.0], t, dilution)
    y = x + 0.01 * x.std(axis=0) * rng.standard_normal(x.shape)
    declared = {"X": "m*S*X - D*X", "S": "D*(5 - S) - r*S*X"}
    model = pse.DeclaredModel(declared, inputs=["D"])
    report = pse.close_loop(model, pse.prepare(t, y, dilution, order=1), random_state=0)
    assert [effect.name for effect in report.effects] == [SATURATING, SATURATING]
    for effect in report.effects:
        assert effect.numbers["half-saturation"] == pytest.approx(0.8, rel=0.05)


def test_surroundings_that_are_measured_but_act_nowhere_take_heat():
    design = pse.DeclaredModel({"T": "c*u"}, inputs=("u", "Ta")).design()
    offered = candidates(design, Ranges.about_zero(np.full(4, 3.0)))
    terms = [c.terms[0] for c in offered if c.name == "coupling"]
    assert sub(variable(2), variable(0)) in terms
    assert sub(variable(1), variable(0)) not in terms  # what heats it is no surroundings


def test_angles_in_degrees_have_a_weight_where_they_go_that_far():
    design = pse.DeclaredModel({"q": "v", "v": "-c*v"}).design()
    for reach, n_sines in ((20.0, 1), (90.0, 2)):
        offered = candidates(design, Ranges.about_zero(np.full(3, reach)))
        weights = [c.terms[0] for c in offered if c.name == "gravity" and not c.parents]
        assert len(weights) == n_sines
    at_right_angle = weights[-1].evaluate(np.array([[90.0, 0.0, 0.0]]))
    assert at_right_angle == pytest.approx([1.0])


def test_a_height_from_which_something_falls_is_no_angle_in_degrees():
    design = pse.DeclaredModel({"h": "v", "v": "-g"}).design()
    reach = Ranges.about_zero(np.full(3, 40.0))
    offered = candidates(design, replace(reach, middle=np.array([20.0, 0.0, 0.0])))
    weights = [c.terms[0].name(("h", "v", "t")) for c in offered if c.name == "gravity"]
    assert weights
    assert not any("0.017" in name for name in weights)


def test_an_angle_in_a_sine_of_the_model_is_in_radians_and_its_multiples_are_no_effects():
    design = pse.DeclaredModel({"q": "v", "v": "a*sin(q) - b*v"}).design()
    offered = candidates(design, Ranges.about_zero(np.full(3, 90.0)))
    names = [c.terms[0].name(("q", "v", "t")) for c in offered]
    assert "cos(q)" in names
    assert "v sin(q)" in names
    assert not [name for name in names if "0.017" in name or name == "q sin(q)"]


@pytest.mark.slow
def test_a_pendulum_in_degrees_has_its_weight_found():
    rng, t = np.random.default_rng(0), np.arange(0.0, 20.0, 0.01)
    model = pse.DeclaredModel({"q": "v", "v": "-30*sin(q) - 0.2*v"}).design().equations([])
    records = []
    for start in (1.5, 1.0, 1.3):
        q = np.rad2deg(pse.simulate(model, [start, 0.0], t)[:, :1])
        records.append(pse.prepare(t, q + 0.1 * rng.standard_normal(q.shape), order=2))
    declared = pse.DeclaredModel({"q": "v", "v": "-c*v"})
    report = pse.close_loop(declared, records[:2], records[2], operators=(), random_state=0)
    (effect,) = report.effects
    assert effect.name == "gravity"
    assert effect.coefficients[0] == pytest.approx(-30.0 * 180.0 / np.pi, rel=0.01)


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
