"""Effects that leave more of the records that they were found in are withdrawn."""

from dataclasses import replace

import numpy as np
import pytest
from loop_systems import equations_of

import pysindy_evolve as pse
from pysindy_evolve.loop.effects.candidate import Candidate
from pysindy_evolve.loop.evidence.findings import Finding, SensorFinding
from pysindy_evolve.loop.evidence.scoring import columns_of
from pysindy_evolve.loop.given.declared import design_of
from pysindy_evolve.loop.given.limits import Limit
from pysindy_evolve.loop.settling.worse_runs import is_further, last_worsened
from pysindy_evolve.terms import power, variable

SIDES = {"q": "v", "v": "50*q - 2*v + F"}  # a ball on a hill, which a controller holds
TRUE = equations_of(SIDES, ("F",))
NEAR = equations_of(SIDES | {"v": "49*q - 2*v + F"}, ("F",))
FAR = equations_of(SIDES | {"v": "30*q - 2*v + F"}, ("F",))


@pytest.fixture(scope="module")
def held():
    t, n = 0.01 * np.arange(2000), 2000
    target, x = 0.1 * np.sin(1.7 * t) + 0.05 * np.sin(4.1 * t), np.zeros((n, 2))
    force = np.zeros((n, 1))
    for k in range(n - 1):
        force[k] = 200.0 * (target[k] - x[k, 0]) - 20.0 * x[k, 1]
        v = x[k, 1] + 0.01 * (50.0 * x[k, 0] - 2.0 * x[k, 1] + force[k, 0])
        x[k + 1] = x[k, 0] + 0.01 * v, v
    noise = 0.05 * np.random.default_rng(0).standard_normal((n, 2))
    return pse.Record(t=t, x=x, x_dot=TRUE.evaluate(x, force, t) + noise * [0, 1], u=force)


@pytest.fixture
def findings(held):
    design = design_of(pse.DeclaredModel({"q": "v", "v": "k*q - c*v + F"}, inputs=["F"]), [held])
    terms = (power(variable(0), 2), power(variable(0), 3))
    bent = [Candidate("stiffness", 1, (term,)) for term in terms]
    found = [Finding(c, columns_of(c, design), 1.0, 0.01, np.zeros(59)) for c in bent]
    clipped = SensorFinding(bent[0], (), 1.0, 0.01, np.zeros(59), limit=Limit(0, 1.0, 100.0, True))
    return [*found, clipped]


def test_the_last_effect_that_changes_an_equation_is_named(findings, held):
    assert last_worsened(findings, NEAR, FAR, [held]) is findings[1]
    assert last_worsened(findings[2:], NEAR, FAR, [held]) is None


def test_a_model_that_leaves_less_keeps_its_effects(findings, held):
    assert last_worsened(findings, FAR, NEAR, [held]) is None
    assert last_worsened(findings, FAR, FAR, [held]) is None


def test_a_run_that_comes_closer_has_the_last_word(held):
    short = held[:40]
    noise = 5.0 * np.random.default_rng(1).standard_normal((40, 1)) * [0, 1]
    bent = replace(short, x_dot=FAR.evaluate(short.x, short.u, short.t) + noise)
    assert not is_further(FAR, TRUE, [bent])
    assert is_further(TRUE, FAR, [short])
