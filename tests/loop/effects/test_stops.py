"""What begins at a place: an end stop, a rope that goes slack."""

import re
from dataclasses import replace

import numpy as np
import pytest
import sympy
from loop_systems import oscillator

import pysindy_evolve as pse
from pysindy_evolve.loop.effects.candidate import Candidate, CandidateMaker
from pysindy_evolve.loop.effects.stops import (
    begins_within,
    begun_at_same,
    damped_contacts,
    has_two_ends,
    is_stop,
    kinked_at_zero,
    one_end_each,
    pressed,
    stops,
)
from pysindy_evolve.loop.evidence.scoring import columns_of
from pysindy_evolve.loop.given.design import Design, in_state
from pysindy_evolve.operators import BUILTIN
from pysindy_evolve.terms import Sum, call, constant, mul, power, sub, variable

STOP = oscillator("dead zone", "- 300*max(q - 0.4, 0)", "-k*q - c*v + b*F")
OFFERED = [*stops(CandidateMaker(0), variable(0), 3.0, 1.0)]
ONE_SIDED = [candidate for candidate in OFFERED if is_stop(candidate)]
TWO_SIDED = [candidate for candidate in OFFERED if has_two_ends(candidate)]
FREE = Design(("q", "v"), (), (variable(1), Sum(())), ())
Q = np.linspace(-3.0, 3.0, 61)[:, None]
OTHER_WAY = variable(1), variable(0)


def test_they_begin_within_the_range_and_are_nothing_on_one_side_of_it():
    for candidate in ONE_SIDED:
        values = candidate.terms[0].evaluate(Q)
        assert 0 < np.count_nonzero(values[(Q[:, 0] > -1.0)] > 1e-9) < 40
        assert values.min() == pytest.approx(0.0, abs=1e-12)


def test_two_stops_have_a_stiffness_each_and_nothing_between_them():
    (wide,) = (c for c in TWO_SIDED if c.terms[1].evaluate(np.array([[0.0]])) == 0.0)
    above, below = (term.evaluate(Q) for term in wide.at([0.5, 2.0]).terms)
    assert above == pytest.approx(np.maximum(Q[:, 0] - 2.0, 0.0))
    assert below == pytest.approx(np.maximum(-0.5 - Q[:, 0], 0.0))


def test_a_stiffness_above_zero_takes_the_place_of_two_ends_only():
    for candidate in OFFERED:
        kinked = kinked_at_zero(candidate)
        assert (kinked is not None) == (candidate in TWO_SIDED)
        if kinked is not None:
            assert kinked.name == "asymmetric stiffness"
            assert kinked.terms[0].evaluate(Q) == pytest.approx(np.maximum(Q[:, 0], 0.0))


@pytest.mark.parametrize(
    ("ends", "comes_in"), [((0.5, 2.0), True), ((0.5, 3.5), False), ((9.0, 9.0), False)]
)
def test_a_stop_comes_in_within_the_range(ends, comes_in):
    (wide,) = (c for c in TWO_SIDED if c.terms[1].evaluate(np.array([[0.0]])) == 0.0)
    assert begins_within(wide.at(ends), Q) is comes_in


def test_two_ends_that_overlap_are_a_straight_line():
    (above,) = (c for c in TWO_SIDED if c.terms[1].evaluate(np.array([[0.0]])) > 0.0)
    assert begins_within(above.at([0.5, 2.0]), Q)
    assert not begins_within(above.at([2.0, 0.5]), Q)


@pytest.mark.parametrize("middle", [-0.5, 0.0, 1.0])
@pytest.mark.parametrize("q", [variable(0), sub(variable(0), variable(1)), sub(*OTHER_WAY)])
def test_of_two_stops_either_may_stand_alone(q, middle):
    rows = np.random.default_rng(0).normal(size=(60, 2))
    for candidate in filter(has_two_ends, stops(CandidateMaker(0), q, 3.0, middle)):
        ends = one_end_each(candidate)
        assert all(map(is_stop, ends))
        for end, term in zip(reversed(ends), candidate.terms, strict=True):
            assert end.terms[0].evaluate(rows) == pytest.approx(term.evaluate(rows))


def test_one_stop_has_one_end():
    for candidate in ONE_SIDED:
        assert one_end_each(candidate) == []


def test_a_contact_may_lose_energy_by_how_deep_it_is_or_wherever_it_is_closed():
    q, v = variable(0), variable(1)
    kink = call(BUILTIN["abs"], sub(q, constant(0.4)))
    _, stop = begun_at_same(Candidate("evolved term", 0, (kink,)))
    columns = [in_state("v", v, 1, 2), *columns_of(replace(stop, state=1), FREE)]
    offered = damped_contacts(CandidateMaker(1), FREE.adding(columns), q, v)
    rows = np.column_stack([Q[:, 0], np.linspace(2.0, -2.0, 61)])
    deep, closed = (candidate.terms[0].evaluate(rows) for candidate in offered)
    below = rows[:, 0] < 0.4
    assert deep == pytest.approx(rows[:, 1] * np.maximum(0.4 - rows[:, 0], 0.0))
    assert closed == pytest.approx(rows[:, 1] * below)


def test_what_begins_to_the_other_side_differs_by_a_straight_line():
    for candidate in ONE_SIDED:
        (other,) = begun_at_same(candidate)
        assert candidate.shape.values == other.shape.values
        difference = candidate.terms[0].evaluate(Q) - other.terms[0].evaluate(Q)
        assert np.diff(difference, n=2) == pytest.approx(0.0, abs=1e-12)
        assert [c.terms for c in begun_at_same(other)] == [candidate.terms]


@pytest.mark.parametrize("place", [0.3, -0.3])
def test_a_grown_magnitude_has_a_dead_zone_to_either_side(place):
    kink = call(BUILTIN["abs"], sub(variable(0), constant(place)))
    above, below = begun_at_same(Candidate("evolved term", 0, (kink,)))
    values = [c.terms[0].evaluate(Q) for c in (above, below)]
    assert values[0] == pytest.approx(np.maximum(Q[:, 0] - place, 0.0))
    assert values[1] == pytest.approx(np.maximum(place - Q[:, 0], 0.0))
    for other in (call(BUILTIN["abs"], variable(0)), mul(kink, variable(0)), power(kink, 3)):
        assert begun_at_same(Candidate("evolved term", 0, (other,))) == []


@pytest.mark.parametrize("place", [0.0, 1e-3])
def test_a_place_next_to_zero_is_left_to_the_magnitude(place):
    found = list(stops(CandidateMaker(0), variable(0), 1.0, 0.2 + place))
    assert all(candidate.shape.values[0] > 0.02 for candidate in found)


@pytest.fixture(scope="module")
def stopped():
    """A loop that finds the end stop."""
    record = STOP.record(duration=20.0)
    return pse.close_loop(STOP.model, record, operators=(), n_twins=59, random_state=0)


def test_an_end_stop_is_found_with_its_place_and_no_offset_beside_it(stopped):
    (effect,) = stopped.effects
    assert effect.name == "dead zone"
    assert effect.numbers["end"] == pytest.approx(0.4, rel=0.02)
    assert effect.coefficients == pytest.approx([-300.0], rel=0.02)
    assert effect.term.func is sympy.Max
    assert f"max(q - {effect.numbers['end']:.4g}, 0)" in str(stopped)


def test_no_sum_is_mentioned_where_the_equations_show_a_stop_by_itself(stopped):
    assert re.search(r"v' = .* - \S+ max\(q - 0\.\d+, 0\)", str(stopped))
    assert "Where an effect below holds" not in str(stopped)


def test_curved_bodies_resist_by_the_depth_to_three_halves():
    for stop in ONE_SIDED:
        depth, force = (one.terms[0].evaluate(Q) for one in (stop, pressed(stop)))
        assert force == pytest.approx(depth**1.5)
        moved = pressed(stop).at([1.1 * value for value in stop.shape.values]).terms[0]
        assert moved.evaluate(Q) != pytest.approx(force)


@pytest.mark.slow
def test_a_stop_that_only_the_end_of_the_stroke_meets_is_found():
    record = STOP.record(duration=20.0)
    place = 0.9 * record.x[:, 0].max()
    rig = oscillator("dead zone", f"- 300*max(q - {place:.3g}, 0)", "-k*q - c*v + b*F")
    record = rig.record(duration=20.0)
    report = pse.close_loop(rig.model, record, operators=(), n_twins=59, random_state=0)
    (effect,) = report.effects
    assert effect.numbers["end"] == pytest.approx(place, rel=0.05)


@pytest.mark.slow
@pytest.mark.parametrize(("amplitude", "seed"), [(0.35, 9511), (0.7, 9509)])
def test_a_stop_that_a_stiff_controller_pushes_into_is_found(amplitude, seed):
    train, test = (pushed(amplitude, own) for own in (seed, seed + 100))
    axis = pse.DeclaredModel({"q": "v", "v": "b*F - c*v"}, inputs=["F"])
    report = pse.close_loop(axis, train, test, operators=(), n_twins=59, random_state=0)
    (effect,) = report.effects
    assert effect.numbers == pytest.approx({"end": 0.6}, rel=1e-3)
    assert effect.coefficients == pytest.approx([-400.0], rel=0.01)


def pushed(amplitude: float, seed: int, n: int = 7500) -> pse.Record:
    """Simulate an axis with a rubber stop at one end, its force held, its position rounded."""
    dt, grain = 2e-3, 2e-5
    t, phases = dt * np.arange(n), np.random.default_rng(seed).uniform(0, 2 * np.pi, 8)
    waves = np.sin(2 * np.pi * np.outer(t, np.linspace(0.1, 1.0, 8)) + phases)
    target = amplitude / 2.0 * waves.sum(axis=1)
    q = v = before = slope = 0.0
    shown, applied = np.empty(n), np.empty(n)
    for k in range(n):
        shown[k] = grain * round(q / grain)
        slope += 0.3 * ((shown[k] - before) / dt - slope)
        before = shown[k]
        applied[k] = 150.0 * (target[k] - before) - 15.0 * slope
        for _ in range(20):
            v += dt / 20 * (applied[k] - 3.0 * v - 400.0 * max(q - 0.6, 0.0))
            q += dt / 20 * v
    return pse.prepare(t, shown, applied, held=True)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 1])
def test_a_crack_that_opens_and_closes_is_one_stiffness(seed):
    """Two ends about zero do as well, and then no record says how stiff either of them is."""
    beam = oscillator("asymmetric stiffness", "+ 6*max(q, 0)")
    report = pse.close_loop(beam.model, beam.record(seed=seed), n_twins=59, random_state=0)
    (effect,) = report.effects
    (coefficient,), q = effect.coefficients, sympy.Symbol("q", real=True)
    # |q| and max(-q, 0) are the same force beside a free spring.
    bend = sum(float(effect.term.subs(q, side)) for side in (1.0, -1.0))
    assert coefficient * bend == pytest.approx(6.0, rel=0.02)


@pytest.mark.slow
def test_contact_of_curved_bodies_is_told_from_a_spring():
    force = "- 400*sqrt(max(q - 0.4, 0))^3"
    rig = oscillator("evolved term", force, "-k*q - c*v + b*F")
    report = pse.close_loop(rig.model, rig.record(duration=20.0), n_twins=59, random_state=0)
    (effect,) = report.effects
    assert effect.numbers["end"] == pytest.approx(0.4, rel=0.05)
    assert effect.coefficients == pytest.approx([-400.0], rel=0.05)
    assert ", 0)^(3/2)" in str(report)


@pytest.mark.slow
def test_two_stops_are_found_where_they_are_and_as_stiff_as_they_are():
    force = "- 300*max(q - 0.3, 0) + 150*max(-q - 0.15, 0)"
    slide = oscillator("dead zone", force, "-k*q - c*v + b*F")
    record = slide.record(duration=20.0)
    report = pse.close_loop(slide.model, record, operators=(), n_twins=59, random_state=0)
    (effect,) = report.effects
    places = {"lower end, below zero": 0.15, "upper end": 0.3}
    assert effect.numbers == pytest.approx(places, rel=0.03)
    assert effect.coefficients == pytest.approx([-300.0, 150.0], rel=0.03)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("force", "name", "places"),
    [
        ("min(max(F, -25), 15)", "saturation", [25, 15]),
        ("F - min(max(F, -12), 5)", "dead zone", [12, 5]),
    ],
)
def test_an_input_may_end_or_begin_at_two_places(force, name, places):
    valve = oscillator(name, f"- F + {force}", "-k*q - c*v + b*F")
    record = valve.record(duration=20.0)
    report = pse.close_loop(valve.model, record, operators=(), n_twins=59, random_state=0)
    (effect,) = report.effects
    assert effect.name == name
    assert list(effect.numbers.values()) == pytest.approx(places, rel=0.03)
    slope = -1.0 if name == "saturation" else 1.0
    assert effect.coefficients == pytest.approx([slope, -slope], rel=0.03)
