"""What to measure next: the proposed motion is one in which an effect and its rival come apart."""

from dataclasses import replace

import numpy as np
import pytest
from loop_systems import equations_of, oscillator

import pysindy_evolve as pse
from pysindy_evolve.loop.given.kinematics import positions
from pysindy_evolve.loop.report.advice import Plan
from pysindy_evolve.loop.report.motions import Motion, Motions

DRAG = oscillator("quadratic drag", "- 0.3*v*abs(v)")
SLOW = {"noise": 0.02, "size": 0.5}


@pytest.fixture(scope="module")
def slow():
    """At low speed, drag and cubic damping leave the same record."""
    return pse.close_loop(DRAG.model, DRAG.record(**SLOW), operators=(), random_state=0)


@pytest.fixture(scope="module")
def cubic(slow):
    """The experiment that tells drag from cubic damping."""
    plan = slow.suggest_experiment(units={"v": "m/s"})
    return next(e for e in plan.experiments if e.alternative.name == "nonlinear damping")


@pytest.mark.slow
def test_drag_and_cubic_damping_at_low_speed_need_a_higher_speed(slow, cubic):
    assert [effect.name for effect in slow.effects] == ["quadratic drag"]
    assert "nonlinear damping" in slow.effects[0].alternatives
    assert cubic.now < 3.0
    assert cubic.then >= 5.0
    here, there, most = cubic.reach["v"]
    assert there > 1.3 * here
    assert abs(most) == pytest.approx(there, rel=0.2)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:.*samples of a test record")
def test_a_record_of_the_proposed_motion_tells_them_apart(slow, cubic):
    # The position is measured by the same sensor, so its noise stays what it was.
    far = cubic.motion.amplitude
    assert cubic.motion.frequency == 1.0
    again = DRAG.record(noise=SLOW["noise"] / far, size=SLOW["size"] * far, seed=3)
    train = [*slow.train, *slow.test, again]
    report = pse.close_loop(DRAG.model, train, test=again, operators=(), random_state=0)
    assert report.effects[0].name == "quadratic drag"
    assert "nonlinear damping" not in report.effects[0].alternatives


@pytest.mark.slow
def test_the_plan_says_it_in_sentences_with_numbers_and_units(slow, cubic):
    said = " ".join(str(slow.suggest_experiment(units={"v": "m/s"})).split())
    here, there, _ = cubic.reach["v"]
    assert said.startswith(
        "1. quadratic drag v |v| or nonlinear damping v^3, in the equation of v?"
    )
    assert f"with {cubic.motion.amplitude:g} times the amplitude" in said
    assert f"|v| up to {there:.3g} m/s (here {here:.3g})" in said
    assert f"raises that to {cubic.then:.1f}" in said


@pytest.mark.slow
def test_a_grown_term_that_got_a_name_is_exchanged_like_any_other(slow):
    columns = [
        replace(column, name="evolved term") if column.name == "quadratic drag" else column
        for column in slow.design.columns
    ]
    grown = replace(slow, design=replace(slow.design, columns=tuple(columns)))
    assert grown.design != slow.design
    assert str(grown.suggest_experiment()) == str(slow.suggest_experiment())


def test_without_alternatives_there_is_nothing_to_tell_apart(report):
    assert all(not effect.rivals for effect in report.effects)
    assert str(report.suggest_experiment()).startswith("Nothing to tell apart")


def test_unit_of_no_variable_is_refused(report):
    with pytest.raises(ValueError, match=r"suggest_experiment\(units=\.\.\.\) must name variables"):
        report.suggest_experiment(units={"w": "m"})


def test_positions_are_read_off_the_equations():
    sides = {"a": "v", "v": "-2*a", "b": "w", "w": "-3*b + v", "c": "2*c"}
    assert positions(equations_of(sides)) == {1: 0, 3: 2}


def test_a_motion_multiplies_amplitudes_and_the_speeds_by_the_frequency_as_well():
    model = equations_of({"q": "v", "v": "-2*q + F"}, ("F",))
    z = np.random.default_rng(0).normal(size=(5, 20, 4))
    moved = Motions(model, z).of(Motion(2.0, 3.0))
    assert moved == pytest.approx(z * [2.0, 6.0, 2.0, 1.0])


def test_motions_begin_with_the_recorded_one_and_grow_from_there():
    model = equations_of({"q": "v", "v": "-2*q + F"}, ("F",))
    efforts = [m.effort for m in Motions(model, np.random.default_rng(0).normal(size=(5, 20, 4)))]
    assert efforts[0] == 0.0
    assert efforts == sorted(efforts)


def test_no_motion_is_beyond_the_reach_of_a_machine():
    model = equations_of({"q": "v", "v": "-2*q + F"}, ("F",))
    motions = list(Motions(model, np.random.default_rng(0).normal(size=(5, 20, 4))))
    assert Motion(5.0, 1.0) in motions
    assert Motion(5.0, 0.2) in motions
    assert Motion(0.2, 5.0) in motions
    assert max(m.amplitude * m.frequency**2 for m in motions) <= 5.0 + 1e-6


def test_a_population_swings_about_its_mean_and_never_below_nothing():
    model = equations_of({"p": "0.5*p"})
    p = 2.0 + 1.5 * np.sin(np.linspace(0.0, 6.0, 50))
    motions = Motions(model, np.column_stack([p, np.arange(50.0)])[None])
    assert motions.of(Motion(2.0, 1.0)) is None
    assert motions.of(Motion(0.5, 1.0))[0, :, 0] == pytest.approx(p.mean() + 0.5 * (p - p.mean()))
    assert {motion.frequency for motion in motions} == {1.0}


@pytest.mark.slow
def test_what_noise_alone_would_tell_apart_needs_another_cause_first(slow, cubic):
    clear = replace(cubic, now=28.4)
    said = " ".join(str(Plan((clear,))).split())
    assert "(28.4 standard errors; five" in said
    assert "Repeat the same experiment: more data" in said
    assert "Repeat the experiment" not in said


@pytest.mark.slow
def test_only_a_report_with_cautions_asks_to_look_at_these_first(cubic):
    clear = replace(cubic, now=28.4)
    for settled in (True, False):
        said = " ".join(str(Plan((clear,), settled=settled)).split())
        assert ("Repeat the same experiment" in said) is settled
        assert ("notes at the end of the report first" in said) is not settled


@pytest.mark.slow
def test_alternatives_that_no_motion_tells_apart_share_one_paragraph(slow, cubic):
    known = [replace(cubic, now=now) for now in (28.4, 7.1)]
    hopeless = [replace(cubic, now=0.5, then=0.6) for _ in range(3)]
    said = " ".join(str(Plan((known[0], hopeless[0], cubic, *hopeless[1:], known[1]))).split())
    assert "(7.1 to 28.4 standard errors; five" in said
    assert said.count("Repeat the same experiment: more data") == 1
    assert said.count("No experiment of up to 5 times") == 1
    assert said.count("Repeat the experiment") == 1
    assert "3. quadratic drag" in said
    assert "4. " not in said


@pytest.mark.slow
def test_no_more_standard_errors_are_printed_than_anybody_needs(cubic):
    said = " ".join(str(Plan((replace(cubic, then=9718.5),))).split())
    assert "raises that to more than 100." in said


@pytest.mark.slow
def test_squares_of_standard_errors_add_up_over_the_record_and_those_to_come(cubic):
    # The same motion once more: 1 becomes the root of 2, and 25 records make it five.
    again = replace(cubic, now=1.0, then=2.0**0.5)
    assert again.n_records == 24
    assert replace(cubic, now=3.0, then=5.0).n_records == 1
    assert replace(cubic, now=1.0, then=1.0).n_records > 1_000_000
