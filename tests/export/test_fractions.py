"""Terms over one denominator are written as one fraction."""

import numpy as np

import pysindy_evolve as pse
from pysindy_evolve.export import format_equations
from pysindy_evolve.export.compact import as_fractions
from pysindy_evolve.export.mathml import equations_mathml

CART = pse.DeclaredModel({"v": "(F - 2*v - sin(q)*v**2)/(4 + sin(q)**2) + 3*v"}, inputs=["F", "q"])


def test_equations_show_one_fraction_and_the_same_values():
    equations = CART.design().equations([])
    text = format_equations(equations)
    assert text == "v' = 3 v + (F - v^2 sin(q) - 2 v)/(sin(q)^2 + 4)"
    (side,) = equations.sums
    rows = np.random.default_rng(0).normal(size=(50, 3))
    np.testing.assert_allclose(as_fractions(side).evaluate(rows), side.evaluate(rows), rtol=1e-12)
    assert r"\frac{F - v^{2} \sin" in pse.to_latex(equations)
    (pieces,) = equations_mathml(equations)
    assert [piece.count("<mfrac>") for piece in pieces] == [0, 0, 1]


def test_a_single_term_over_a_sum_stays_as_it_is():
    equations = pse.DeclaredModel({"x": "2*x/(1 + x) - 3*x"}).design().equations([])
    (side,) = equations.sums
    assert as_fractions(side) == side
