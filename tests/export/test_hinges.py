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
        ("3*u - 0.4*min(max(u, -2), 2)", "3 u - 0.4 min(max(u, -2), 2)"),
        ("3*u - 2.9*min(max(u, -2), 2)", "0.1 u + 2.9 max(u - 2, 0) - 2.9 max(-u - 2, 0)"),
        ("3*min(max(u, -2), 2) - v", "-v + 3 min(max(u, -2), 2)"),
        ("3*sqrt(abs(q))*min(max(u, -2), 2) - v", "-v + 3 sqrt(|q|) min(max(u, -2), 2)"),
        ("v*abs(q) - 2*abs(v)", "-2 |v| + v |q|"),
        ("-2*abs(q - 0.3)", "-2 |q - 0.3|"),
        ("3*min(max(u, -2), 1) - v", "-v + 3 min(max(u, -2), 1)"),
        ("3*max(0, min(1, 2*u - q))", "6 min(max(u - 0.5 q, 0), 0.5)"),
        ("2*max(u, 0) - v", "-v + 2 max(u, 0)"),
        ("-2*v - abs(v)", "-2 v - |v|"),
        ("-v - 2*sqrt(max(q - 0.5, 0))", "-v - 2 sqrt(max(q - 0.5, 0))"),
        ("-sqrt(abs(q - 0.5))*(1 + sgn(q - 0.5)) - v", "-v - 2 sqrt(max(q - 0.5, 0))"),
        ("-v - u*sqrt(abs(q))*(1 - sgn(q))", "-v - 2 u sqrt(max(-q, 0))"),
        ("-v - 2*max(q - 0.5, 0)**0.6", "-v - 2 max(q - 0.5, 0)^0.6"),
        ("-v - 2*max(q - 0.5, 0)**1.5", "-v - 2 max(q - 0.5, 0)^(3/2)"),
        ("-v + 3*max(q - u, 0)**1.3", "-v + 3 max(q - u, 0)^1.3"),
        ("-v + 3*max(q - u, 0)**1.3*(u - q)", "-v - 3 max(q - u, 0)^2.3"),
        (
            "-v + (q - 1)*sqrt(max(q - 0.5, 0))",
            "-v - sqrt(max(q - 0.5, 0)) + q sqrt(max(q - 0.5, 0))",
        ),
        (
            "-v*abs(q - 0.5)*sin(u)**2 - v*(q - 0.5)",
            "0.5 v - q v - v sin(u)^2 |q - 0.5|",
        ),
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


@pytest.mark.parametrize(
    ("language", "limit", "hinge"),
    [
        ("python", "numpy.minimum(1, numpy.maximum(-1, u))", "2*numpy.maximum(0, q - 0.5)"),
        ("julia", "min(1, max(-1, u))", "2 * max(0, q - 0.5)"),
        ("matlab", "min(1, max(-1, u))", "2*max(0, q - 0.5)"),
        ("c", "fmin(1.0, fmax(-1.0, u))", "2.0*fmax(0.0, q - 0.5)"),
        ("modelica", "min(1, max(-1, u))", "2*max(0, q - 0.5)"),
    ],
)
def test_exported_code_has_hinges_and_limits(language, limit, hinge):
    side = "min(max(u, -1), 1) - 2*max(q - 0.5, 0)"
    equations = pse.DeclaredModel({"q": side}, inputs=["u"]).design().equations([])
    code = pse.to_code(equations, language)
    assert limit in code
    assert hinge in code
