"""What is below the line keeps away from zero."""

import numpy as np
import pytest

from pysindy_evolve.breeding.dictionary import Problem
from pysindy_evolve.breeding.poles import has_pole, keeps_sign
from pysindy_evolve.breeding.refit import refit
from pysindy_evolve.operators import BUILTIN
from pysindy_evolve.terms import add, call, constant, div, mul, power, sub, variable

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
        (mul(SPEED, power(add(power(SPEED, 2), constant(0.1)), -1)), False),
        (mul(SPEED, power(add(power(SPEED, 2), constant(1e-3)), -1)), True),
        (mul(SPEED, power(sub(power(SPEED, 2), constant(0.1)), -1)), True),
        (power(add(constant(0.1), add(GAP, power(GAP, 2))), -1), False),
        (power(add(constant(-0.49), add(GAP, power(GAP, 2))), -1), True),
    ],
)
def test_a_term_that_divides_by_what_crosses_zero_has_a_pole(term, expected):
    assert has_pole(term, ROWS) == expected


@pytest.mark.parametrize(
    ("term", "expected"),
    [
        (power(GAP, -1), False),
        (power(sub(GAP, constant(0.5)), -1), False),
        (power(SPEED, -1), True),
    ],
)
def test_what_begins_at_zero_does_not_cross_it(term, expected):
    assert has_pole(term, ROWS, keeps_sign) == expected


def test_the_terms_of_an_equation_do_not_divide_by_what_crosses_zero():
    """A pole between two samples fits what these two have by chance."""
    rng = np.random.default_rng(0)
    x = rng.uniform(-1.0, 1.0, (400, 2))
    target = 2.0 * x[:, 0]
    target[np.abs(x[:, 1] + 0.1).argmin()] += 3.0
    q, v = (variable(i) for i in range(2))
    ((_, straight),), ((_, pole),) = q.parts, div(q, add(v, constant(0.1))).parts
    terms, coef = refit(Problem(x, target, np.empty((400, 0))), (straight, pole), 2, 5)
    assert terms == (straight,)
    assert coef[0] == pytest.approx(2.0, abs=0.02)
