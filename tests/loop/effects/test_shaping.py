"""Numbers inside effects, as a report tells them."""

import pytest

from pysindy_evolve.loop.effects.candidate import Candidate
from pysindy_evolve.loop.effects.shaping import tuned_shape
from pysindy_evolve.operators import BUILTIN
from pysindy_evolve.terms import add, call, constant, mul, variable

Q = variable(0)


def grown(name, *inside):
    return Candidate("evolved term", 1, (call(BUILTIN[name], *inside),))


def test_numbers_of_a_grown_term_are_inner_constants():
    steep = tuned_shape(grown("tanh", mul(constant(-198.0), Q)))
    assert steep.named == {"inner constant": pytest.approx(198.0)}
    shifted = tuned_shape(grown("sin", add(mul(constant(2.1), Q), constant(0.3))))
    assert list(shifted.named) == ["first inner constant", "second inner constant"]
    assert sorted(shifted.named.values()) == pytest.approx([0.3, 2.1])


def test_each_of_several_numbers_has_its_own_meaning():
    uptake = mul(
        call(BUILTIN["cos"], mul(constant(0.5), Q)),
        call(BUILTIN["softsign"], mul(constant(4.0), Q)),
    )
    shape = tuned_shape(Candidate("evolved term", 1, (uptake,)))
    assert set(shape.meanings) == {"inner constant", "half-saturation constant"}


def test_the_exponent_of_a_hill_function_is_no_level():
    power = call(BUILTIN["exp"], mul(constant(3.0), call(BUILTIN["log"], call(BUILTIN["abs"], Q))))
    shape = tuned_shape(grown("softsign", mul(constant(0.3), power)))
    assert list(shape.named) == ["constant in the denominator", "exponent"]
    assert tuned_shape(grown("exp", mul(constant(1.75), call(BUILTIN["log"], Q)))).named == {
        "exponent": pytest.approx(1.75)
    }


def test_a_number_that_nobody_tuned_is_not_told():
    assert tuned_shape(grown("sin", Q)) is None
    assert tuned_shape(Candidate("viscous damping", 1, (Q,))) is None


def test_a_number_that_the_declared_model_gives_is_not_told():
    beside = grown("tanh", mul(constant(-198.0), Q))
    assert tuned_shape(beside, frozenset({198.0})) is None
    assert tuned_shape(beside, frozenset({3.0})) is not None
