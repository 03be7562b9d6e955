"""Plain terms with numbers: in the first generation, tuned beside a straight line."""

import numpy as np
import pytest

from pysindy_evolve.breeding.constants import tune, tune_beside
from pysindy_evolve.breeding.dictionary import Problem, build_dictionary
from pysindy_evolve.breeding.plain import plain_terms
from pysindy_evolve.evolution import evolve
from pysindy_evolve.library import OPERATORS
from pysindy_evolve.operators import BUILTIN, resolve
from pysindy_evolve.terms import ONE, call, constant, mul, only_term, variable


@pytest.fixture
def x():
    return np.random.default_rng(0).uniform(0.2, 4.0, size=(1500, 2))


def test_functions_without_a_number_come_once_and_alone_where_nothing_multiplies(x):
    names = {term.name(["x", "y"]) for term in plain_terms(resolve(("add", "sgn", "abs")), x - 2.0)}
    assert names == {"sgn(x)", "abs(x)", "sgn(y)", "abs(y)"}


def test_reciprocals_are_of_variables_that_keep_their_sign(x):
    x[:, 1] -= 2.0
    names = [term.name(["x", "y"]) for term in plain_terms(resolve(("add", "div")), x)]
    assert names
    assert all(name.startswith("1/(") and "x)" in name for name in names)


def test_operators_of_two_arguments_make_none(x):
    assert plain_terms(resolve(("add", "mul")), x) == []


def test_a_term_is_tuned_beside_a_straight_line(x):
    leaves = (ONE, only_term(variable(0)), only_term(variable(1)))
    problem = Problem(x, 2.0 * np.sin(1.3 * x[:, 1]) - x[:, 0], np.empty((len(x), 0)))
    terms = [*leaves, *plain_terms(resolve(OPERATORS), x)]
    tuned = tune_beside(build_dictionary(problem, terms), leaves)
    found = [
        c for term in tuned if term.name(["x", "y"]).startswith("sin(") for c in term.constants
    ]
    assert min(abs(c - 1.3) for c in found) < 1e-3


def test_a_function_is_not_tuned_into_a_straight_line(x):
    wave = only_term(call(BUILTIN["sin"], mul(constant(0.5), variable(0))))
    (tuned,) = tune([wave], x, x[:, 0] + 1e-4 * x[:, 0] ** 3, np.empty((len(x), 0)))
    assert tuned.constants[0] * np.ptp(x[:, 0]) >= 0.3


@pytest.mark.parametrize(
    ("operators", "truth", "names"),
    [
        (OPERATORS, lambda x, y: -0.5 * x + 2.0 * np.sin(1.3 * y), {"x", "sin(1.3 y)"}),
        pytest.param(
            ("add", "mul", "exp"),
            lambda x, y: np.exp(-0.6 * x) + 0.5 * y,
            {"y", "exp(-0.6 x)"},
            marks=pytest.mark.slow,
        ),
        (("add", "mul", "exp"), lambda x, y: x - y * np.exp(-0.5 * x), {"x", "y exp(-0.5 x)"}),
    ],
    ids=["sin", "exp", "Arrhenius"],
)
def test_an_inner_constant_beside_other_terms_is_found_whatever_the_seed(
    x, operators, truth, names
):
    clean = truth(*x.T)
    y = clean + 0.01 * clean.std() * np.random.default_rng(1).normal(size=len(x))
    found = 0
    for seed in range(4):
        rng = np.random.default_rng(seed)
        evolution = evolve(x, y, operators=resolve(operators), rng=rng)
        rounded = [
            t.with_constants([float(f"{c:.2g}") for c in t.constants]) for t in evolution.terms
        ]
        found += {term.name(["x", "y"]) for term in rounded} == names
    assert found >= 3  # one or two of four before


def test_no_term_is_without_a_value_where_a_record_begins():
    t = np.arange(0.0, 10.0, 0.01)[:, None]
    y = np.where(t > 0.0, np.sin(t) / np.maximum(t, 1e-9), 1.0)[:, 0]
    whole = evolve(
        t[1:], y[1:], operators=resolve(("mul", "div", "sin")), rng=np.random.default_rng(0)
    )
    kept = evolve(
        t[1:],
        y[1:],
        operators=resolve(("mul", "div", "sin")),
        rng=np.random.default_rng(0),
        domain=t[:1],
    )
    with np.errstate(all="ignore"):
        assert not all(np.isfinite(term.evaluate(t)).all() for term in whole.terms)
    assert all(np.isfinite(term.evaluate(t)).all() for term in kept.terms)
