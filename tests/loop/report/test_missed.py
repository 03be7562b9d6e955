"""What the report says of a model that misses the record."""

import re

import numpy as np
import pytest
from loop_systems import equations_of, multisine, oscillator

import pysindy_evolve as pse
from pysindy_evolve.loop.facts.residuals import percent_left
from pysindy_evolve.loop.report.number_text import percent, percent_cell

DRAG = equations_of({"h": "v", "v": "-9.81 - 0.05*v*Abs(v)"})
T = np.arange(50) / 15.0


def fall(seed, noise=0.03):
    """A light ball that falls from a bridge, filmed."""
    exact = pse.simulate(DRAG, [47.0, 0.0], T)[:, :1]
    return pse.prepare(T, exact + noise * np.random.default_rng(seed).standard_normal(exact.shape))


def test_who_is_told_to_judge_by_the_derivative_is_told_what_is_left_of_it():
    declared = pse.DeclaredModel({"h": "v", "v": "-9.81"})
    report = pse.close_loop(declared, fall(0), fall(1), max_effects=0, random_state=0)
    said = " ".join(str(report).split())
    assert report.after.simulation_error.max() > 100.0
    assert "judge by the derivative. In the training data the model leaves" in said


@pytest.mark.slow
@pytest.mark.parametrize(
    ("friction", "strength", "sentence"),
    [
        (0.0, 0.0, "complete: nothing is missing"),
        (0.0, 20.0, "complete: none of the effects that were tried passes"),
        (4.0, 0.0, "traced: the model lacked the effects below, which have been added. Declared"),
        (
            10.0,
            9.0,
            "traced: the model lacked the effects below, which have been added; it leaves more",
        ),
        (
            10.0,
            20.0,
            "traced in part: the model lacked the effects below, which have been added, but it "
            "still misses the record",
        ),
    ],
)
def test_a_model_that_a_random_force_drives_off_is_not_said_to_lack_nothing(
    friction, strength, sentence
):
    t, rng = np.arange(0.0, 20.0, 0.01), np.random.default_rng(0)
    force, push = multisine(20.0, 0)(t), strength * rng.standard_normal(2000)
    truth = equations_of(oscillator("friction", f"- {friction}*sgn(v)").truth, ("F",))
    q = pse.simulate(truth, [0.0, 0.0], t, force + push)[:, :1]
    record = pse.prepare(t, q + 1e-3 * q.std() * rng.standard_normal(q.shape), force)
    declared = oscillator("nothing", "").model
    report = pse.close_loop(declared, record, operators=(), random_state=0)
    assert report.verdict == ("traced" if friction else "complete")
    said = " ".join(str(report).split())
    assert said.startswith(f"Verdict: {sentence}")
    assert ("something is missing that is not among these effects" in said) == (strength > 0.0)


@pytest.mark.parametrize(
    ("value", "text", "cell"),
    [
        (0.31, "0.31 %", "0.31"),
        (99.4, "99 %", "99.4"),
        (99.6, "100 %", "99.6"),
        (999.4, "999 %", "999"),
        (999.6, "10 times the standard deviation", "10 times"),
        (2345.6, "23 times the standard deviation", "23 times"),
        (1.79e7, "over 1000 times the standard deviation", "over 1000 times"),
    ],
)
def test_percents_are_written_without_powers_of_ten_and_from_tenfold_on_as_a_factor(
    value, text, cell
):
    assert (percent(value), percent_cell(value)) == (text, cell)


@pytest.fixture(scope="module")
def ramp():
    """Report of a state that falls in a line, beside one that is driven, the first forgotten."""
    t = np.arange(0.0, 20.0, 0.01)
    rows = np.column_stack([3.0 - 0.5 * t, 0.4 * (1.0 - np.cos(2.0 * t))])
    record = pse.prepare(t, rows, np.sin(2.0 * t), order=1)
    declared = pse.DeclaredModel({"x": "a*y", "y": "b*u"}, inputs=["u"])
    options = {"max_effects": 1, "operators": (), "n_twins": 59, "random_state": 0}
    return pse.close_loop(declared, record, **options)


def test_what_a_model_leaves_of_a_ramp_is_no_share_of_its_derivative(ramp):
    assert ramp.before.derivative_error[0] > 1e7
    assert np.isnan(percent_left(ramp.after.model, ramp.train)[0])
    assert percent_left(ramp.after.model, ramp.train)[1] < 1.0
    said = " ".join(str(ramp).split())
    assert "constant offset in the equation of x" in said
    assert "the model leaves" not in said


def test_no_number_of_percent_above_a_thousand_is_printed(ramp):
    for said in (str(ramp), ramp.to_markdown()):
        assert "over 1000 times" in said
        assert not re.search(r"\d{4,}(\.\d+)? %|e\+\d+ %", " ".join(said.split()))
        (row,) = (line for line in said.splitlines() if line.strip(" |").startswith("declared"))
        assert all(
            float(cell) <= 1000.0 for cell in re.findall(r"(?<= )[\d.e+-]+(?! times)\b", row)
        )
