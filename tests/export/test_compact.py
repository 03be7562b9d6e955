"""Sums as people write them."""

import pytest
import sympy

from pysindy_evolve.export.compact import compact

P, Q = sympy.symbols("p q", real=True)


@pytest.mark.parametrize("power", [(P - Q) ** 2, (P - Q) ** 3, -((Q - P) ** 5), (P + 2.0 * Q) ** 3])
def test_a_power_that_was_multiplied_out_is_one_again(power):
    shown = compact(sympy.expand(power))
    assert shown.count_ops() <= power.count_ops() + 1
    assert sympy.expand(shown - sympy.nsimplify(power)) == 0


@pytest.mark.parametrize(
    "other", [P, P - Q, P**2 + Q, P**2 * Q + P * Q + Q, sympy.Abs(P) + P**2 + Q, sympy.Integer(1)]
)
def test_other_expressions_stay_as_they_are(other):
    assert compact(other) is other
