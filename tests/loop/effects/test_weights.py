"""An angle has a weight, in radians or in degrees; a height has none."""

from dataclasses import replace

import numpy as np
import pytest

import pysindy_evolve as pse
from pysindy_evolve.loop.effects.missing import candidates
from pysindy_evolve.loop.given.ranges import Ranges


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
