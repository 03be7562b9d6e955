"""What acts the less the larger a variable is."""

import numpy as np
import pytest

import pysindy_evolve as pse


def tank(seed):
    """A level that a pump of constant power raises, the slower the higher it is."""
    rng, t = np.random.default_rng(seed), 0.1 * np.arange(2000)
    inflow = np.interp(t, np.arange(40) * 5.2, rng.uniform(0.5, 3.0, 40))
    model = pse.DeclaredModel({"x": "-0.3*x + 0.2*u + 0.25/x"}, inputs=["u"])
    x = pse.simulate(model.design().equations([]), [2.0], t, inflow, tolerance=1e-9)
    y = x + 5e-3 * x.std() * rng.standard_normal(x.shape)
    return pse.prepare(t, y, inflow, order=1)


@pytest.mark.slow
def test_a_reciprocal_grows():
    declared = pse.DeclaredModel({"x": "-a*x + b*u"}, inputs=["u"])
    report = pse.close_loop(declared, tank(100), tank(101), random_state=0)
    (effect,) = report.effects
    assert (effect.name, str(effect.term)) == ("evolved term", "1/x")
    assert effect.coefficients == pytest.approx([0.25], rel=0.02)
