"""To first order, runs tell which term would do better in the place of an effect."""

import numpy as np
import pytest
from loop_systems import oscillator

from pysindy_evolve.loop.effects.candidate import OFFSET, Candidate
from pysindy_evolve.loop.evidence.scoring import columns_of
from pysindy_evolve.loop.fitting.fit import refit
from pysindy_evolve.loop.free_runs.drift import drift_of
from pysindy_evolve.loop.free_runs.leading_terms import leading_terms, stand_ins
from pysindy_evolve.loop.free_runs.variants import Model
from pysindy_evolve.loop.given.declared import design_of
from pysindy_evolve.operators import BUILTIN
from pysindy_evolve.terms import call, constant, mul, variable

Q, V, F = (variable(k) for k in range(3))
SPRING = oscillator("a spring that stiffens", "- 15*q*abs(q)", "-k*q - c*v + b*F + o")


def evolved(term, parents=()):
    return Candidate("evolved term", 1, (term,), parents)


CUBE = Candidate("cubic stiffness", 1, (mul(Q, mul(Q, Q)),))
SQUARE = evolved(mul(Q, call(BUILTIN["abs"], Q)))


@pytest.fixture(scope="module")
def drift():
    """Runs of the machine's model with a cubic spring in the place of a quadratic one."""
    record = SPRING.record(noise=2e-3)
    design = design_of(SPRING.model, [record])
    whole = design.adding(columns_of(CUBE, design))
    return drift_of(Model(whole), refit(whole, [record], "derivative"), [record])


def test_the_term_that_acts_comes_first(drift):
    others = [evolved(call(BUILTIN["tanh"], mul(constant(c), Q))) for c in (1.0, 3.0)]
    found = stand_ins(drift, CUBE, [*others, SQUARE], 0.05)
    assert found[0] == SQUARE


def test_of_terms_that_differ_in_a_number_the_best_one_stands_for_all(drift):
    rates = np.linspace(0.1, 4.0, 20)
    many = [evolved(mul(Q, call(BUILTIN["cos"], mul(constant(c), Q)))) for c in rates]
    assert len(stand_ins(drift, CUBE, many, 0.0)) == 1


def test_what_does_not_act_in_the_effect_or_may_not_enter_is_left_out(drift):
    elsewhere = [evolved(call(BUILTIN["sgn"], F)), Candidate("evolved term", 0, SQUARE.terms)]
    unparented = evolved(SQUARE.terms[0], parents=(mul(V, V),))
    assert stand_ins(drift, CUBE, [*elsewhere, unparented, CUBE], -np.inf) == []
    assert stand_ins(drift, CUBE, [evolved(SQUARE.terms[0], parents=(OFFSET,))], 0.05)


def test_the_term_that_acts_has_no_stand_in():
    record = SPRING.record(noise=2e-3)
    design = design_of(SPRING.model, [record])
    whole = design.adding(columns_of(SQUARE, design))
    runs = drift_of(Model(whole), refit(whole, [record], "derivative"), [record])
    rivals = [CUBE, evolved(call(BUILTIN["sin"], Q)), evolved(call(BUILTIN["tanh"], Q))]
    assert stand_ins(runs, SQUARE, rivals, 0.05) == []


def test_what_runs_miss_most_comes_first_beside_a_model_and_nothing_beside_the_right_one():
    record = SPRING.record(noise=2e-3)
    design = design_of(SPRING.model, [record])
    runs = drift_of(Model(design), refit(design, [record], "derivative"), [record])
    offered = [evolved(call(BUILTIN["sgn"], Q)), SQUARE, evolved(call(BUILTIN["cos"], F))]
    assert leading_terms(runs, offered, 0.69)[0] == SQUARE
    right = design.adding(columns_of(SQUARE, design))
    better = drift_of(Model(right), refit(right, [record], "derivative"), [record])
    assert leading_terms(better, offered, 0.05) == []
