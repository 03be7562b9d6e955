"""Which of the effects that a short record allows is named."""

from dataclasses import replace

import numpy as np
import pytest
from loop_systems import equations_of, oscillator

import pysindy_evolve as pse
from pysindy_evolve.loop.effects.candidate import OFFSET, Candidate
from pysindy_evolve.loop.evidence.findings import Finding
from pysindy_evolve.loop.evidence.rivals import Rival
from pysindy_evolve.loop.evidence.scoring import columns_of
from pysindy_evolve.loop.given.declared import design_of
from pysindy_evolve.loop.settling.contest import with_plainest_effect, without_refuted_rivals
from pysindy_evolve.operators import BUILTIN
from pysindy_evolve.terms import call, constant, mul, power, sub, variable

H, V, T = variable(0), variable(1), variable(2)
COUPLING = Candidate("coupling", 1, (mul(H, V),))
DAMPING = Candidate("viscous damping", 1, (V,))
CUBIC = Candidate("nonlinear damping", 1, (power(V, 3),))
CONSTANT = Candidate("constant offset", 1, (OFFSET,))
DRIFT = Candidate("drift", 1, (T,))


@pytest.fixture(scope="module")
def design():
    t = np.arange(40) / 15.0
    record = pse.prepare(t, 47.0 - 4.9 * t**2)
    return design_of(pse.DeclaredModel({"h": "v", "v": "-9.81"}), [record])


def found(candidate, design, *rivals):
    own = Finding(candidate, columns_of(candidate, design), 1.0, 0.01, np.zeros(39))
    return replace(own, rivals=tuple(Rival(one, p_value) for one, p_value in rivals))


def test_what_depends_on_one_state_is_named_before_what_depends_on_two(design):
    named = with_plainest_effect(
        found(COUPLING, design, (DAMPING, 0.2), (CUBIC, 0.1)), design, 0.05
    )
    assert named.candidate == DAMPING
    assert named.columns == columns_of(DAMPING, design)
    assert [rival.name for rival in named.rivals] == ["coupling", "nonlinear damping"]


def test_what_depends_on_states_is_named_before_what_depends_on_the_time(design):
    named = with_plainest_effect(found(DRIFT, design, (COUPLING, 0.6), (CUBIC, 0.1)), design, 0.05)
    assert named.candidate == CUBIC


def test_a_plainer_effect_that_is_less_likely_than_the_significance_is_not_named(design):
    kept = found(COUPLING, design, (DAMPING, 0.04), (DRIFT, 0.5))
    assert with_plainest_effect(kept, design, 0.05) is kept


def test_of_effects_as_plain_as_each_other_the_one_that_was_found_is_named(design):
    kept = found(CUBIC, design, (DAMPING, 0.9))
    assert with_plainest_effect(kept, design, 0.05) is kept


@pytest.mark.slow
def test_of_a_constant_and_what_cannot_be_told_from_it_the_constant_is_named():
    t = np.arange(0.0, 200.0, 0.1)
    heated = equations_of({"T": "0.4*u - 0.2*(T - 20) + 0.5"}, ("u",))
    u = np.repeat(np.random.default_rng(0).uniform(0.0, 3.0, 40), 50)
    x = pse.simulate(heated, [22.0], t, u) + 1e-3 * np.random.default_rng(1).normal(size=(2000, 1))
    record = pse.prepare(t, x, u, order=1)
    model = pse.DeclaredModel({"T": "b*u - a*(T - 20)"}, inputs=["u"])
    report = pse.close_loop(model, record, operators=(), random_state=0)
    assert report.effects[0].name == "constant offset"


def test_a_constant_takes_no_place(design):
    kept = found(COUPLING, design, (CONSTANT, 0.9))
    assert with_plainest_effect(kept, design, 0.05) is kept


def test_an_alternative_without_a_value_on_some_rows_is_none():
    machine = oscillator("cubic stiffness", "- 9*q**3")
    record = machine.record()
    design = design_of(machine.model, [record])
    highest = record.x[:, 0].max()
    below = sub(constant(0.99 * highest), variable(0))  # has no root where q is highest
    root = Candidate("valve flow", 1, (call(BUILTIN["sqrt"], below),))
    cubic = Candidate("cubic stiffness", 1, (power(variable(0), 3),))
    similar = Candidate("quintic stiffness", 1, (power(variable(0), 5),))
    (kept,) = without_refuted_rivals(
        design, [found(cubic, design, (root, 0.5), (similar, 0.5))], [record]
    )
    assert "valve flow" not in [rival.name for rival in kept.rivals]
