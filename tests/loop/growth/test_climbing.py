"""A grown term moves to the best one near it, one factor at a time, its numbers tuned."""

import numpy as np
import pytest
from loop_systems import measured

import pysindy_evolve as pse
from pysindy_evolve.loop.effects.candidate import Candidate
from pysindy_evolve.loop.given.declared import design_of
from pysindy_evolve.loop.given.segments import segments
from pysindy_evolve.loop.growth.climbing import climbed
from pysindy_evolve.loop.growth.genetic_search import OPERATORS
from pysindy_evolve.operators import BUILTIN, resolve
from pysindy_evolve.terms import call, constant, mul, power, variable

Q, F = variable(0), variable(2)
GOVERNOR = pse.DeclaredModel({"q": "v", "v": "-g*sin(q) - c*v + b*F"}, inputs=["F"])


def swing(rate):
    return call(BUILTIN["sin"], mul(constant(rate), Q))


@pytest.fixture(scope="module")
def governor():
    """Design and pieces of a pendulum that the square of a speed lifts."""
    truth = {"q": "v", "v": "-9.8*sin(q) - 0.5*v + F + 0.3*F^2*sin(2*q)"}
    record = measured(truth, noise=2e-3, size=4.0, duration=60.0)
    return design_of(GOVERNOR, [record]), segments([record])


def at_the_top(start, governor):
    begin = Candidate("evolved term", 1, (start,))
    (term,) = climbed(begin, *governor, resolve(OPERATORS, "test")).terms
    return term


@pytest.mark.parametrize(
    "start",
    [
        mul(call(BUILTIN["abs"], F), swing(1.5)),  # another factor, and then another rate
        mul(power(F, 2), call(BUILTIN["tanh"], Q)),
        mul(mul(power(F, 2), swing(1.8)), call(BUILTIN["exp"], mul(constant(0.1), F))),
    ],
)
def test_a_term_near_the_true_one_becomes_it(governor, start):
    found = at_the_top(start, governor)
    assert found.constants == pytest.approx([2.0], rel=0.02)
    true = mul(power(F, 2), swing(found.constants[0]))
    assert found == true


def test_the_true_term_stays_where_it_is(governor):
    found = at_the_top(mul(power(F, 2), swing(2.0)), governor)
    assert found == mul(power(F, 2), swing(found.constants[0]))


def test_what_the_model_holds_already_is_left_alone(governor):
    assert at_the_top(variable(1), governor) == variable(1)


def test_a_climb_is_the_same_each_time(governor):
    start = mul(call(BUILTIN["abs"], F), swing(1.5))
    first, second = (at_the_top(start, governor) for _ in range(2))
    assert first == second
    assert np.isfinite(first.constants).all()
