"""Coefficients that free runs give: closer to the truth, and exact slopes across switches."""

from dataclasses import replace

import numpy as np
import pytest

import pysindy_evolve as pse
from pysindy_evolve.datasets import friction_drive
from pysindy_evolve.loop.fitting.fit import Fit, fit
from pysindy_evolve.loop.fitting.runs import simulation_errors
from pysindy_evolve.loop.fitting.saltation import saltation
from pysindy_evolve.loop.fitting.shooting import _longest_trial, _run, _settled, fit_by_shooting
from pysindy_evolve.loop.given.declared import design_of

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
    refined = fit_by_shooting(design, linear, [train])
    assert np.max(np.abs(linear.coef / TRUTH - 1.0)) > 0.02  # else there is nothing to better
    assert refined.coef == pytest.approx(TRUTH, rel=0.01)
    assert refined.criterion == "simulation"
    errors = [simulation_errors(design.equations(f.coef), [test])[0] for f in (linear, refined)]
    assert errors[1] < 0.5 * errors[0]


def test_intervals_move_with_their_coefficients(drive):
    train, _, design = drive
    linear = fit(design, [train], np.random.default_rng(0))
    refined = fit_by_shooting(design, linear, [train])
    moved = refined.intervals - linear.intervals
    assert moved == pytest.approx(np.repeat((refined.coef - linear.coef)[:, None], 2, axis=1))


# Equations, coefficients, start: smooth or not, first to third order, with and without sticking.
SYSTEMS = {
    "smooth": ({"q": "v", "v": "-k*q - c*v + b*u"}, {"k": 10.0, "c": 0.5, "b": 3.0}, (0.0, 0.0)),
    "first order": ({"v": "b*u - c*v - d*sgn(v)"}, {"b": 2.0, "c": 0.5, "d": 0.8}, (1.0,)),
    "drive": ({"q": "v", "v": "b*u - c*v - d*sgn(v)"}, {"b": 2.0, "c": 0.5, "d": 0.8}, (0.0, 1.0)),
    "relay": ({"v": "b*sgn(u - v) - c*v"}, {"b": 2.0, "c": 0.5}, (1.0,)),
    "third order": (
        {"q": "v", "v": "a", "a": "-g*a - k*v - d*sgn(v) + b*u"},
        {"g": 2.0, "k": 4.0, "d": 1.0, "b": 3.0},
        (0.0, 0.5, 0.0),
    ),
    "two masses": (
        {"q": "v", "v": "-k*q - d*sgn(v - w) + b*u", "p": "w", "w": "-m*p + d*sgn(v - w)"},
        {"k": 8.0, "d": 0.2, "b": 2.0, "m": 5.0},
        (0.5, 0.0, 0.0, 0.3),
    ),
}


@pytest.mark.parametrize("name", SYSTEMS)
def test_small_changes_move_the_runs_as_the_sensitivities_say(name):
    equations, values, start = SYSTEMS[name]
    design = pse.DeclaredModel(equations, inputs=["u"]).design()
    truth = np.array([values[column.name] for column in design.columns])
    t = np.arange(0.0, 20.0, 0.01)
    u = (2.0 * np.sin(1.3 * t) + np.sin(3.1 * t + 1.0) + np.cos(0.4 * t))[:, None]
    model = design.equations(truth)
    x = pse.simulate(model, start, t, u=u)
    record = pse.Record(t=t, x=x, x_dot=model.evaluate(x, u, t), u=u)
    shooting = _longest_trial(design, truth, [record])
    free, response = shooting.sensitivities(keep=1)

    def off(told, coef, starts):
        moved = _run(replace(shooting, coef=coef, starts=starts), [record]).x - shooting.x
        expected = (moved / shooting.scale).reshape(len(moved), -1)
        told = told[:, : expected.shape[1]]
        return np.linalg.norm(told - expected) / np.linalg.norm(expected)

    for k, coefficient in enumerate(truth):
        small = 1e-5 * coefficient
        coef = truth + small * (np.arange(len(truth)) == k)
        assert off(small * response[:, :, k], coef, shooting.starts) < 0.03
    for j, size in enumerate(1e-5 * shooting.part.state_scale):
        starts = shooting.starts + size * (np.arange(len(start)) == j)
        assert off(size / shooting.scale[j] * free[:, :, j], truth, starts) < 0.03


def test_a_model_without_switches_has_no_saltation():
    design = pse.DeclaredModel({"v": "-c*v*abs(v) + u"}, inputs=["u"]).design()
    assert saltation(design.equations([1.0]), np.zeros((1, 5, 3)), np.ones(1), 0.1) is None


def test_of_a_body_that_sticks_no_deviation_is_left():
    design = pse.DeclaredModel({"q": "v", "v": "u - d*sgn(v)"}, inputs=["u"]).design()
    z = np.zeros((1, 4, 4))
    z[0, :, 1] = 0.1, 0.0, 0.0, 0.0
    matrices = saltation(design.equations([1.0]), z, np.ones(2), 0.1)
    assert matrices[0] == pytest.approx(np.broadcast_to(np.diag([1.0, 0.0]), (3, 2, 2)), abs=1e-5)


def test_a_model_that_cannot_follow_the_record_keeps_its_coefficients(drive):
    train, _, design = drive
    wrong = Fit(-TRUTH, np.zeros((3, 2)), "derivative")
    assert fit_by_shooting(design, wrong, [train]) is wrong


def test_long_records_are_left_to_the_linear_fit(drive, monkeypatch):
    train, _, design = drive
    linear = fit(design, [train], np.random.default_rng(0))
    monkeypatch.setattr("pysindy_evolve.loop.fitting.shooting.MAX_ROWS", len(train) - 1)
    assert fit_by_shooting(design, linear, [train]) is linear


def test_a_step_never_makes_the_error_larger(drive):
    train, _, design = drive
    shooting = _longest_trial(design, 1.02 * TRUTH, [train])
    assert _settled(shooting, [train]).error < shooting.error
    exact = shooting.aimed_at(shooting.shown)
    assert exact.error == 0.0
    assert _settled(exact, [train]).error == 0.0
