"""What is below the line keeps away from zero."""

import numpy as np
import pytest

from pysindy_evolve.loop.growth.grow import OPERATORS, _without_quotients
from pysindy_evolve.loop.growth.poles import has_pole
from pysindy_evolve.operators import BUILTIN, resolve
from pysindy_evolve.terms import add, call, constant, mul, power, variable

GAP, SPEED = variable(0), variable(1)
ROWS = np.column_stack([np.linspace(0.5, 1.5, 200), np.linspace(-2.0, 2.01, 200)])


@pytest.mark.parametrize(
    ("term", "expected"),
    [
        (power(GAP, -2), False),
        (power(SPEED, -1), True),
        (mul(power(GAP, -1), SPEED), False),
        (call(BUILTIN["exp"], power(SPEED, -1)), True),
        (mul(GAP, power(add(SPEED, constant(3.0)), -1)), False),
        (mul(GAP, power(add(SPEED, constant(1.0)), -1)), True),
        (call(BUILTIN["tanh"], SPEED), False),
    ],
)
def test_a_term_that_divides_by_what_crosses_zero_has_a_pole(term, expected):
    assert has_pole(term, ROWS) == expected


def test_a_search_divides_only_where_there_are_sums_to_divide_by():
    plain = [operator.name for operator in _without_quotients(resolve(OPERATORS))]
    assert "div" in OPERATORS
    assert plain == [name for name in OPERATORS if name != "div"]
    rational = resolve(("add", "mul", "div"))
    assert _without_quotients(rational) == list(rational)
