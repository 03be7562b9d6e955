"""Noise that shifts coefficients makes nothing look as if it were missing."""

from functools import partial

import numpy as np
import pytest
from loop_systems import equations_of, measured, multisine

import pysindy_evolve as pse
from pysindy_evolve.loop.evidence.p_values import chance_of, without_noise_shift
from pysindy_evolve.loop.evidence.scoring import propose, quick_fit
from pysindy_evolve.loop.evidence.spectrum_or_trajectory import pieces_to_score
from pysindy_evolve.loop.evidence.step import _best_score
from pysindy_evolve.loop.given.resampling import widened
from pysindy_evolve.loop.given.rules import Rules
from pysindy_evolve.loop.twins.chance import chance_on_twins
from pysindy_evolve.loop.twins.twins import TwinMaker

STIFFNESS = 2000.0
TRUTH = {
    "m": "w",
    "w": "5*F - 1.5*w - 2000*(m - q) - 2*(w - v)",
    "q": "v",
    "v": "1333*(m - q) + 1.333*(w - v) - 0.667*v",
}
SHAFT = {
    "m": "w",
    "w": "b*F - c*w - k*(m - q) - d*(w - v)",
    "q": "v",
    "v": "r*(m - q) + s*(w - v) - e*v",
}


def shaft(twists_per_noise, duration=24.0, seed=0):
    """Return a motor that turns a load by an elastic shaft, both angles measured with noise."""
    model, force = equations_of(TRUTH, ("F",)), multisine(3.0, seed, (0.1, 6.0))
    t = np.arange(0.0, duration, 0.004)
    y = pse.simulate(model, [0.0] * 4, t, force)[:, ::2]
    noise = (y[:, 0] - y[:, 1]).std() / twists_per_noise
    return pse.prepare(
        t, y + noise * np.random.default_rng(seed).standard_normal(y.shape), force(t)
    )


def seen(record, sides=SHAFT):
    design = pse.DeclaredModel(sides, inputs=["F"]).design()
    records = widened([record])
    part = pieces_to_score(design, records)
    return design, quick_fit(design, part), part, records


def stiffness(equations):
    return -equations.evaluate(np.array([[1.0, 0.0, 0.0, 0.0]]), np.zeros((1, 1)), np.zeros(1))[
        0, 1
    ]


def test_the_stiffness_of_a_shaft_whose_twist_is_noisy_is_found_in_twins():
    design, equations, part, records = seen(shaft(3.0))
    assert stiffness(equations) < 0.8 * STIFFNESS
    maker = TwinMaker.of(equations, records)
    unshifted = without_noise_shift(maker, design, part, np.random.default_rng(0))
    assert stiffness(unshifted) == pytest.approx(STIFFNESS, rel=0.1)


def test_noise_that_shifts_nothing_leaves_a_fit_as_it_is():
    sides = {"q": "v", "v": "-k*q - c*v + b*F"}
    truth = {"q": "v", "v": "-40*q - 0.8*v + F"}
    design, equations, part, records = seen(measured(truth, noise=5e-3), sides)
    maker = TwinMaker.of(equations, records)
    assert without_noise_shift(maker, design, part, np.random.default_rng(0)) is None


@pytest.mark.slow
def test_what_noise_makes_of_a_shaft_is_no_effect():
    design, equations, part, records = seen(shaft(2.0))
    statistic = partial(_best_score, design=design, proposer=propose)
    observed, rules = statistic(part), Rules(0.05, 59, 0.05, 8)
    rng = np.random.default_rng
    maker = TwinMaker.of(equations, records)
    _, plain = chance_on_twins(maker, part, statistic, observed, rules, rng(0))
    assert np.sum(plain >= observed) == 0
    draws = [
        chance_of(observed, statistic, design, equations, part, rules, rng(seed))[0]
        for seed in range(3)
    ]
    assert np.median(draws) > rules.level
