"""What the report says of a model that misses the record."""

import numpy as np
import pytest
from loop_systems import equations_of

import pysindy_evolve as pse
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


@pytest.mark.parametrize(
    ("value", "text"), [(0.31, "0.31 %"), (99.4, "99 %"), (99.6, "100 %"), (2345.6, "2346 %")]
)
def test_percents_are_written_without_powers_of_ten(value, text):
    assert percent(value) == text
