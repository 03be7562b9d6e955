"""Curves that no product of operators is: powers, Hill functions, steps, lengths."""

import numpy as np
import pytest
import sympy
from loop_systems import measured

import pysindy_evolve as pse
from pysindy_evolve.loop.effects.candidate import Candidate
from pysindy_evolve.loop.given.declared import design_of
from pysindy_evolve.loop.given.segments import segments
from pysindy_evolve.loop.growth.climbing import climbed
from pysindy_evolve.loop.growth.curves import curves
from pysindy_evolve.loop.growth.genetic_search import OPERATORS
from pysindy_evolve.operators import BUILTIN, resolve
from pysindy_evolve.terms import call, constant, mul, variable

KNOWN = resolve(OPERATORS, "test")
W = variable(0)


def climbed_from(start, force, rest):
    """Return the record of a braked shaft, and the term to which another one climbs."""
    truth = {"w": f"{rest} + F - 0.5*w + {force}", "h": "0.5*w - h"}
    record = measured(truth, noise=1e-3, size=4.0, duration=60.0, order=1, x0=(3.0, 1.0))
    declared = pse.DeclaredModel({"w": "-c*w + b*F + d", "h": "k*w - l*h"}, inputs=["F"])
    begin = Candidate("evolved term", 0, (start,))
    (term,) = climbed(begin, design_of(declared, [record]), segments([record]), KNOWN).terms
    return record, term.to_sympy(sympy.symbols("w h F", real=True))


def tanh(x, factor):
    return call(BUILTIN["tanh"], mul(constant(factor), x))


def test_curves_have_values_wherever_the_variables_were():
    rng = np.random.default_rng(0)
    x = np.column_stack([rng.standard_normal(50), rng.uniform(1.0, 3.0, 50), np.ones(50)])
    found = curves(KNOWN, x, n_states=2)
    assert len(found) == len(set(found)) > 30
    assert all(np.isfinite(curve.evaluate(x)).all() for curve in found)
    assert not any(2 in curve.variables for curve in found)  # which never varied


def test_there_are_none_without_the_operators_they_consist_of():
    x = np.random.default_rng(0).standard_normal((50, 2))
    assert curves(resolve(("mul", "exp", "log"), "test"), x, n_states=2) == []


def test_lengths_are_of_states_only():
    x = np.random.default_rng(0).standard_normal((50, 4))
    lengths = [c for c in curves(KNOWN, x, n_states=3) if len(c.variables) > 1]
    assert sorted(sorted(c.variables) for c in lengths) == [[0, 1], [0, 1, 2], [0, 2], [1, 2]]


def test_a_power_has_the_size_of_what_is_printed():
    power = call(BUILTIN["exp"], mul(constant(1.75), call(BUILTIN["log"], W)))
    assert power.size == mul(constant(1.75), W).size + 1 == 3
    assert power.to_sympy([sympy.Symbol("w", real=True)]) == sympy.Symbol("w", real=True) ** 1.75


@pytest.mark.parametrize(
    ("force", "start", "rest"),
    [("-0.2*w^1.6", mul(W, tanh(W, 0.2)), 8), ("-2*w^3/(27 + w^3)", tanh(W, 0.3), 3)],
)
def test_a_similar_term_becomes_the_curve(force, start, rest):
    w = sympy.Symbol("w", real=True)
    record, found = climbed_from(start, force, rest)
    wanted = sympy.sympify(force.replace("^", "**"), {"w": w})
    values = np.linspace(record.x[:, 0].min(), record.x[:, 0].max(), 50)
    shape, true = (sympy.lambdify(w, one, "numpy")(values) for one in (found, wanted))
    beside = np.column_stack([shape, values, np.ones(50)])  # declared terms are fitted with it
    left = true - beside @ np.linalg.lstsq(beside, true, rcond=None)[0]
    plain = true - beside[:, 1:] @ np.linalg.lstsq(beside[:, 1:], true, rcond=None)[0]
    assert np.linalg.norm(left) < 0.03 * np.linalg.norm(plain), found
