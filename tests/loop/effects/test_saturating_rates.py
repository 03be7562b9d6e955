"""Rates that saturate with a level are found with the level at which they are half as large."""

import numpy as np
import pytest
from loop_systems import equations_of

import pysindy_evolve as pse
from pysindy_evolve.loop.effects.missing import candidates
from pysindy_evolve.loop.effects.names import SATURATING
from pysindy_evolve.loop.effects.shaping import FROM_RECIPROCALS
from pysindy_evolve.loop.given.ranges import Ranges


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


def test_another_substance_may_compete_for_what_saturates_already():
    """A rate that is straight in one variable may be anything, and is not tried."""
    for rate, expected in (("S/(2 + S)", "S/(3 + 1.5 S + I)"), ("S*F", "S F/(3 + I)"), ("S", "")):
        design = pse.DeclaredModel({"S": f"a*F - m*{rate}"}, inputs=["F", "I"]).design()
        ranges = Ranges.of(np.random.default_rng(0).uniform(1.0, 3.0, (500, 4)))
        found = {c.at([3.0]).terms[0] for c in candidates(design, ranges) if c.name == SATURATING}
        names = {term.name(("S", "F", "I", "t")) for term in found if 2 in term.variables}
        assert expected in names if expected else not names


def test_the_number_of_a_rate_stands_in_its_denominator_as_it_is():
    """Only those of grown quotients are built from reciprocals."""
    design = pse.DeclaredModel({"S": "-m*S/(2 + S)", "J": "-k*J*S"}).design()
    ranges = Ranges.of(np.random.default_rng(0).uniform(1.0, 3.0, (500, 3)))
    found = [c for c in candidates(design, ranges) if c.name == SATURATING]
    assert {"inhibition constant", "half-saturation"} <= {
        m for c in found for m in c.shape.meanings
    }
    assert not [c for c in found if c.shape.meanings[0].endswith(FROM_RECIPROCALS)]


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


def test_each_form_of_a_rate_is_tuned_by_itself():
    """The best form may be the worst of all with the numbers of the grid."""
    design = pse.DeclaredModel({"X": "m*S*X/(1 + S) - a*X", "S": "-y*S*X/(1 + S)"}).design()
    ranges = Ranges.of(np.random.default_rng(0).uniform(1.0, 3.0, (500, 3)))
    found = [c for c in candidates(design, ranges) if c.name == SATURATING and c.state == 0]
    on_one_branch: dict[int, set] = {}
    for one in found:
        terms = tuple(one.at([0.7]).terms[0].parts)
        on_one_branch.setdefault(one.branch, set()).add(terms)
    assert len(on_one_branch) == 5
    assert all(len(forms) <= 2 for forms in on_one_branch.values())  # with X, and with S


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
    report = pse.close_loop(model, pse.prepare(t, y, dilution, order=1), n_twins=59, random_state=0)
    assert [effect.name for effect in report.effects] == [SATURATING, SATURATING]
    for effect in report.effects:
        assert effect.numbers["half-saturation"] == pytest.approx(0.8, rel=0.05)


@pytest.mark.slow
@pytest.mark.parametrize("loss", ["y", "2*m"])
def test_what_inhibits_its_own_uptake_is_found_in_both_equations(loss):
    """A chemostat after Haldane, declared after Monod; both equations may share a coefficient."""
    t, rng = np.arange(0.0, 400.0, 0.2), np.random.default_rng(0)
    stairs = [np.repeat(rng.uniform(*ends, 20), 100) for ends in ((0.05, 0.3), (6.0, 14.0))]
    inputs = np.column_stack([np.convolve(u, np.ones(15) / 15.0, "same") for u in stairs])
    inputs = inputs[15:-15]
    uptake = "0.5*S*X/(1.2 + S + S^2/9)"
    chemostat = {"X": f"{uptake} - D*X", "S": f"D*(F - S) - 2*{uptake}"}
    x = pse.simulate(equations_of(chemostat, ("D", "F")), [3.0, 3.0], t[: len(inputs)], inputs)
    y = x + 0.01 * x.std(axis=0) * rng.standard_normal(x.shape)
    declared = {"X": "m*S/(1.2 + S)*X - D*X", "S": f"D*(F - S) - {loss}*S/(1.2 + S)*X"}
    model = pse.DeclaredModel(declared, inputs=["D", "F"])
    record = pse.prepare(t[: len(inputs)], y, inputs, order=1)
    report = pse.close_loop(model, record, operators=(), n_twins=59, random_state=0)
    assert [effect.name for effect in report.effects] == [SATURATING, SATURATING]
    for effect in report.effects:  # over its constant, the denominator is 1 + S/1.2 + S^2/10.8
        assert effect.numbers["inhibition level"] == pytest.approx(10.8**0.5, rel=0.05)
    assert (report.after.simulation_error < 1.0).all()
    assert "it acts" not in str(report)  # D multiplies X too, but a rate is no force


@pytest.mark.slow
def test_a_product_that_inhibits_its_reaction_is_found_in_three_equations_at_once():
    """They share a coefficient: an effect in one of them alone would change it in the others."""
    t, rng = np.arange(0.0, 200.0, 0.2), np.random.default_rng(0)
    stairs = [
        np.repeat(rng.uniform(*ends, 25), 40) for ends in ((0.1, 1.0), (0.5, 4.0), (0.0, 3.0))
    ]
    inputs = np.column_stack([np.convolve(u, np.ones(11) / 11.0, "same") for u in stairs])
    t, inputs = t[:-20], inputs[10:-10]
    reaction = "0.8*A*B/(1 + 0.6*C)"
    flows = {"A": "D*(3 - A) - {0}", "B": "D*(E - B) - {0}", "C": "D*(G - C) + {0}"}
    reactor = {state: side.format(reaction) for state, side in flows.items()}
    x = pse.simulate(equations_of(reactor, ("D", "E", "G")), [1.0, 1.0, 1.0], t, inputs)
    y = x + 0.003 * x.std(axis=0) * rng.standard_normal(x.shape)
    declared = {state: side.format("k*A*B") for state, side in flows.items()}
    model = pse.DeclaredModel(declared, inputs=["D", "E", "G"])
    record = pse.prepare(t, y, inputs, order=1)
    report = pse.close_loop(model, record, operators=(), n_twins=59, random_state=0)
    assert {effect.state: effect.name for effect in report.effects} == dict.fromkeys(
        "ABC", SATURATING
    )
    for effect in report.effects:
        assert effect.numbers["half-saturation"] == pytest.approx(1.0 / 0.6, rel=0.02)
    assert (report.after.simulation_error < 0.05 * report.before.simulation_error).all()
