"""What the report says of a model that misses the record."""

import numpy as np
import pytest
from loop_systems import equations_of, multisine, oscillator

import pysindy_evolve as pse
from pysindy_evolve.loop.report.text import MUCH_LEFT, VERDICTS
from pysindy_evolve.loop.report.units import percent

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


@pytest.mark.parametrize(("strength", "sentence"), [(0.0, VERDICTS["complete"]), (20.0, MUCH_LEFT)])
def test_a_complete_model_that_a_random_force_drives_off_is_not_said_to_lack_nothing(
    strength, sentence
):
    t, rng = np.arange(0.0, 20.0, 0.01), np.random.default_rng(0)
    force, push = multisine(20.0, 0)(t), strength * rng.standard_normal(2000)
    truth = equations_of(oscillator("nothing", "").truth, ("F",))
    q = pse.simulate(truth, [0.0, 0.0], t, force + push)[:, :1]
    record = pse.prepare(t, q + 1e-3 * q.std() * rng.standard_normal(q.shape), force)
    declared = oscillator("nothing", "").model
    report = pse.close_loop(declared, record, operators=(), random_state=0)
    assert report.verdict == "complete"
    said = " ".join(str(report).split())
    assert said.startswith(f"Verdict: {sentence} Declared")
    assert ("something is missing that is not among these effects" in said) == (strength > 0.0)


@pytest.mark.parametrize(
    ("value", "text"), [(0.31, "0.31 %"), (99.4, "99 %"), (99.6, "100 %"), (2345.6, "2346 %")]
)
def test_percents_are_written_without_powers_of_ten(value, text):
    assert percent(value) == text
