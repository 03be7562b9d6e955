"""A magnet brakes most at one speed, and less beyond it."""

import numpy as np
import pytest
from loop_systems import measured

import pysindy_evolve as pse


@pytest.mark.slow
@pytest.mark.parametrize("critical", [1.0, 2.5])
def test_an_eddy_current_brake_is_neither_dry_friction_nor_stribeck(critical):
    model = pse.DeclaredModel({"q": "v", "v": "-k*q - c*v + b*F"}, inputs=["F"])
    truth = {"q": "v", "v": f"-9*q - 0.6*v + F - 1.2*v/(1 + (v/{critical})**2)"}
    records = [measured(truth, noise=5e-4, seed=seed) for seed in (5, 6)]
    report = pse.close_loop(model, *records, random_state=0)
    (effect,) = report.effects
    assert effect.name == "eddy-current drag"
    assert effect.numbers["critical speed"] == pytest.approx(critical, rel=0.05)
    np.testing.assert_allclose(effect.coefficients, -1.2, rtol=0.05)
    assert report.after.parameters["c"] == pytest.approx(0.6, abs=0.05)
