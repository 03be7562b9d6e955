"""Which fit of a short record the errors and coefficients of a report come from."""

from dataclasses import replace

import numpy as np
import pytest
from loop_systems import equations_of

import pysindy_evolve as pse
from pysindy_evolve.loop.given.declared import design_of
from pysindy_evolve.loop.given.rules import Rules
from pysindy_evolve.loop.settling.judge import judge

RULES = Rules(0.05, 59, 0.05, 8, by_trajectory=True)
DECAY = {"q": "v", "v": "-40*q - 0.8*v - 3*sgn(v)"}
FALL = {"h": "v", "v": "-9.81 - 0.05*v*Abs(v)"}


def filmed(sides, start, t, noise, seed):
    exact = pse.simulate(equations_of(sides), start, t)[:, :1]
    return pse.prepare(t, exact + noise * np.random.default_rng(seed).standard_normal(exact.shape))


def judged(sides, train, test):
    design = design_of(pse.DeclaredModel(sides), [train])
    return judge(design, (), [train], [test], RULES, np.random.default_rng(0), final=True)


@pytest.mark.parametrize("seed", [0, 1])
def test_a_random_force_does_not_take_the_blame_for_the_friction_of_a_free_decay(seed):
    t = np.arange(80) / 25.0
    train, test = filmed(DECAY, [1.0, 0.0], t, 5e-3, seed), filmed(DECAY, [0.8, 0.0], t, 5e-3, 9)
    fitted, errors = judged({"q": "v", "v": "-k*q - c*v - f*sgn(v)"}, train, test)
    assert fitted.criterion != "trajectory"
    assert fitted.coef == pytest.approx([40.0, 0.8, 3.0], rel=0.1)  # the trajectory says f = 1.2
    assert errors.simulation_error.max() < 10.0


def test_a_trajectory_that_nothing_beats_keeps_its_fit():
    t = np.arange(50) / 15.0
    train, test = (filmed(FALL, [47.0, 0.0], t, 0.03, seed) for seed in (0, 1))
    fitted, _ = judged({"h": "v", "v": "-9.81 - c*v*Abs(v)"}, train, test)
    assert fitted.criterion == "trajectory"


def test_held_out_data_do_not_decide_between_fits():
    t = np.arange(80) / 25.0
    train = filmed(DECAY, [1.0, 0.0], t, 5e-3, 0)
    sides = {"q": "v", "v": "-k*q - c*v - f*sgn(v)"}
    own, _ = judged(sides, train, filmed(DECAY, [0.8, 0.0], t, 5e-3, 9))
    other, _ = judged(sides, train, replace(train, x_dot=-train.x_dot))
    assert np.array_equal(own.coef, other.coef)
