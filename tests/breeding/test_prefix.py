"""Prefix trees: a term written as one is the same term when it is read again."""

import pytest

from pysindy_evolve.breeding.prefix import from_prefix, to_prefix
from pysindy_evolve.operators import BUILTIN
from pysindy_evolve.terms import add, call, constant, div, mul, power, sub, variable

Q, V = variable(0), variable(1)
EXPRESSIONS = (
    constant(1.0),
    Q,
    mul(power(Q, 2), call(BUILTIN["sgn"], V)),
    div(V, mul(power(Q, 2), add(constant(0.7), Q))),
    call(BUILTIN["sin"], sub(mul(constant(1.7), Q), V)),
)


@pytest.mark.parametrize("expression", EXPRESSIONS, ids=lambda one: one.parts[0][1].name("qv"))
def test_a_term_is_read_as_it_was_written(expression):
    ((_, term),) = expression.parts
    assert from_prefix(to_prefix(term), {}) == expression


def test_an_operator_stands_before_its_arguments():
    sgn = BUILTIN["sgn"]
    ((_, term),) = mul(Q, call(sgn, V)).parts
    assert to_prefix(term) == [BUILTIN["mul"], Q, sgn, V]
