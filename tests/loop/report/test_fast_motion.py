"""Motion that the low-pass took out of a record is told from what the record shows."""

import numpy as np
import pytest
from loop_systems import equations_of

import pysindy_evolve as pse

TRUTH = equations_of({"q": "v", "v": "-v - 900*q - 9000*q**3 + u"}, ("u",))
SIDES = {"q": "v", "v": "-b*v - k*q - n*q**3 + u"}
T = np.arange(0.0, 12.0, 0.005)


def shaken(speed, force, seed):
    """A hardening spring, shaken at one angular frequency: its harmonics lie three times higher."""
    u = force * np.sin(speed * T)
    q = pse.simulate(TRUTH, [0.01, 0.0], T, u)[:, :1]
    noise = 1e-4 * np.random.default_rng(seed).standard_normal(q.shape)
    return pse.prepare(T, q + noise, u)


def report_of(declared, train, test):
    report = pse.close_loop(declared, train, test=test, max_effects=0, random_state=0)
    return report, " ".join(str(report).split())


@pytest.fixture(scope="module")
def slow_and_fast():
    train = [shaken(12.0, 60.0, 0), shaken(20.0, 80.0, 1), shaken(35.0, 120.0, 2)]
    test = shaken(28.0, 200.0, 9)
    assert min(record.cutoff for record in train) < 0.5 * test.cutoff
    return train, test


def test_records_of_slow_motion_set_the_low_pass_of_a_fast_one(slow_and_fast):
    train, test = slow_and_fast
    report, said = report_of(pse.DeclaredModel(SIDES, inputs=["u"]), train, test)
    alone = report.simulate(test) - test.x
    errors = 100.0 * np.sqrt(np.mean(alone**2, axis=0)) / test.x.std(axis=0)
    assert (errors < 0.5 * report.after.simulation_error).all()
    assert "Most of the free run's error in v is motion faster than" in said


def test_an_error_of_the_model_is_not_blamed_on_the_low_pass(slow_and_fast):
    wrong = pse.DeclaredModel(SIDES, inputs=["u"], known={"n": 8000.0})
    report, said = report_of(wrong, *slow_and_fast)
    assert 5.0 < report.after.simulation_error.max() < 100.0
    assert "Most of the free run's error" not in said
