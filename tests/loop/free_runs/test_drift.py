"""Over how long a stretch a model is run before its runs say nothing."""

import numpy as np
import pytest
from loop_systems import equations_of, multisine

import pysindy_evolve as pse
from pysindy_evolve.loop.free_runs.drift import drift_of
from pysindy_evolve.loop.free_runs.variants import Model
from pysindy_evolve.loop.given.declared import design_of

STRETCHES = (16, 32, 64, 128)


def beam(stiffening):
    """A beam that hardens, pushed so hard that its motion is chaotic if it hardens much."""
    truth = {"q": "v", "v": f"-200*q - {stiffening}*q^3 - v + F"}
    t, force = np.arange(0.0, 28.0, 0.004), multisine(60.0, 3, band=(0.5, 6.0))
    q = pse.simulate(equations_of(truth, ("F",)), [0.0, 0.0], t, force, tolerance=1e-8)[:, 0]
    record = pse.prepare(t, q, force(t))
    model = pse.DeclaredModel({"q": "v", "v": "-k*q - a*q^3 - c*v + b*F"}, inputs=["F"])
    return record, Model(design_of(model, [record])), np.array([200.0, stiffening, 1.0, 1.0])


def test_chaotic_motion_is_run_over_shorter_stretches_if_no_deviation_may_grow_much():
    record, model, coef = beam(3000.0)
    far, near = (drift_of(model, coef, [record], STRETCHES, most) for most in (1e3, 5.0))
    assert len(far.part.z) == 16
    assert len(near.part.z) == 64
    assert near.trial.coef == pytest.approx(coef, rel=0.1)


def test_calm_motion_is_run_over_the_longest_ones_all_the_same():
    record, model, coef = beam(0.0)
    drift = drift_of(model, coef, [record], STRETCHES, 5.0)
    assert len(drift.part.z) == 16


def test_a_stiff_spring_is_no_chaos_though_a_small_deviation_becomes_a_large_speed():
    """A load on a stiff shaft that follows a motor: its speed deviates 18 times as far at once."""
    truth = {"p": "w", "w": "-9000*p - 2*w + 9000*a"}
    t, angle = np.arange(0.0, 28.0, 0.004), multisine(1.0, 3, band=(0.1, 1.0))
    p = pse.simulate(equations_of(truth, ("a",)), [0.0, 0.0], t, angle, tolerance=1e-8)[:, 0]
    record = pse.prepare(t, p, angle(t))
    declared = pse.DeclaredModel({"p": "w", "w": "k*(a - p) - c*w"}, inputs=["a"])
    model = Model(design_of(declared, [record]))
    coef = np.array([9000.0, 2.0])
    assert len(drift_of(model, coef, [record], STRETCHES, 5.0).part.z) == 16
