"""What begins at a place is written as max(q - c, 0), what ends at two as min(max(u, -c), c)."""

import numpy as np
import pytest
import sympy

import pysindy_evolve as pse
from pysindy_evolve.export import format_equations

ROWS = np.random.default_rng(0).normal(size=(100, 3))


@pytest.mark.parametrize(
    ("side", "expected"),
    [
        ("-20*q - 300*max(q - 0.3, 0)", "-20 q - 300 max(q - 0.3, 0)"),
        ("-20*q - 300*max(-q - 0.3, 0) + u", "-20 q + u - 300 max(-q - 0.3, 0)"),
        (
            "-20*q - 300*max(q - 0.3, 0) + 150*max(-q - 0.1, 0)",
            "-20 q + 150 max(-q - 0.1, 0) - 300 max(q - 0.3, 0)",
        ),
        (
            "-200*max(q - 0.3, 0) - 3*v*max(q - 0.3, 0)",
            "-200 max(q - 0.3, 0) - 3 v max(q - 0.3, 0)",
        ),
        ("3*min(max(u, -2), 2) - v", "-v + 3 min(max(u, -2), 2)"),
        ("v*abs(q) - 2*abs(v)", "-2 |v| + v |q|"),
        ("-2*abs(q - 0.3)", "-2 |q - 0.3|"),
        ("3*min(max(u, -2), 1) - v", "-v + 3 min(max(u, -2), 1)"),
        ("3*max(0, min(1, 2*u - q))", "6 max(-0.5 q + u, 0) - 6 max(-0.5 q + u - 0.5, 0)"),
        ("2*max(u, 0) - v", "-v + 2 max(u, 0)"),
        ("-2*v - abs(v)", "-2 v - |v|"),
        ("-v - 2*sqrt(max(q - 0.5, 0))", "-v - 2 sqrt(max(q - 0.5, 0))"),
        ("-sqrt(abs(q - 0.5))*(1 + sgn(q - 0.5)) - v", "-v - 2 sqrt(max(q - 0.5, 0))"),
        ("-v - u*sqrt(abs(q))*(1 - sgn(q))", "-v - 2 u sqrt(max(-q, 0))"),
    ],
)
def test_hinges_read_as_they_were_declared_and_have_the_same_values(side, expected):
    equations = pse.DeclaredModel({"q": "v", "v": side}, inputs=["u"]).design().equations([])
    first, second = format_equations(equations).splitlines()
    assert first == "q' = v"
    assert second == f"v' = {expected}"
    values = equations.evaluate(ROWS[:, :2], ROWS[:, 2:], np.zeros(100))[:, 1]
    _, shown = pse.to_sympy(equations)
    by_sympy = sympy.lambdify(sympy.symbols("q v u", real=True), shown)(*ROWS.T)
    np.testing.assert_allclose(by_sympy, values, rtol=1e-9, atol=1e-9)
