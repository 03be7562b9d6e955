"""Coefficients that free runs give: closer to the truth, and exact slopes across switches."""

from dataclasses import replace

import numpy as np
import pytest

import pysindy_evolve as pse
from pysindy_evolve.datasets import friction_drive
from pysindy_evolve.loop.declared import design_of
from pysindy_evolve.loop.fit import Fit, fit
from pysindy_evolve.loop.runs import simulation_errors
from pysindy_evolve.loop.shooting import _begun, _run, shot

TRUTH = np.array([0.5, 3.0, 1.5])  # 1/m, viscous and Coulomb friction over the mass
COMPLETE = pse.DeclaredModel({"q": "v", "v": "b*F - c*v - d*sgn(v)"}, inputs=["F"])


@pytest.fixture(scope="module")
def drive():
    """Prepared training and test record of a drive with dry friction, and its design."""
    made = friction_drive(random_state=1, duration=10.0)
    train, test = (pse.prepare(r.t, r.y, r.u) for r in (made.train, made.test))
    return train, test, design_of(COMPLETE, [train])


def test_free_runs_come_closer_to_the_truth_than_the_linear_fit(drive):
    train, test, design = drive
    linear = fit(design, [train], np.random.default_rng(0))
    refined = shot(design, linear, [train])
    assert np.max(np.abs(linear.coef / TRUTH - 1.0)) > 0.02  # else there is nothing to better
    assert refined.coef == pytest.approx(TRUTH, rel=0.01)
    assert refined.criterion == "simulation"
    errors = [simulation_errors(design.equations(f.coef), [test])[0] for f in (linear, refined)]
    assert errors[1] < 0.5 * errors[0]


def test_intervals_move_with_their_coefficients(drive):
    train, _, design = drive
    linear = fit(design, [train], np.random.default_rng(0))
    refined = shot(design, linear, [train])
    moved = refined.intervals - linear.intervals
    assert moved == pytest.approx(np.repeat((refined.coef - linear.coef)[:, None], 2, axis=1))


def test_slopes_hold_where_the_drive_turns_and_sticks(drive):
    """A small change of a coefficient moves the runs as `sensitivities` says."""
    train, _, design = drive
    shooting = _begun(design, TRUTH, [train])
    velocity = shooting.x[:, :, 1]
    assert np.sum((velocity[:, 1:] <= 0.0) & (velocity[:, :-1] > 0.0)) > 5
    _, response = shooting.sensitivities(keep=1)
    for k, coefficient in enumerate(TRUTH):
        small = 1e-5 * coefficient
        coef = TRUTH + small * (np.arange(3) == k)
        moved = _run(design, coef, shooting.starts, shooting.part, [train]) - shooting.x
        expected = (moved / shooting.scale).reshape(len(moved), -1)
        told = small * response[:, : expected.shape[1], k]
        assert np.linalg.norm(told - expected) < 0.1 * np.linalg.norm(expected)


def test_a_model_that_cannot_follow_the_record_keeps_its_coefficients(drive):
    train, _, design = drive
    wrong = Fit(-TRUTH, np.zeros((3, 2)), "derivative")
    assert shot(design, wrong, [train]) is wrong


def test_long_records_are_left_to_the_linear_fit(drive, monkeypatch):
    train, _, design = drive
    linear = fit(design, [train], np.random.default_rng(0))
    monkeypatch.setattr("pysindy_evolve.loop.shooting.MAX_ROWS", len(train) - 1)
    assert shot(design, linear, [train]) is linear


def test_a_step_never_makes_the_error_larger(drive):
    train, _, design = drive
    shooting = _begun(design, 1.02 * TRUTH, [train])
    assert shooting.settled().error < shooting.error
    exact = replace(shooting, x=shooting.part.z[:, :, :2].copy())
    assert exact.error == 0.0
    assert exact.settled().error == 0.0
