"""Operators: numpy and sympy agree, and bad ones are named."""

import pickle

import numpy as np
import pytest
import sympy

from pysindy_evolve.operators import BUILTIN, Operator, resolve

POINTS = np.array([-1.7, -0.3, 0.0, 0.4, 2.2])
# Where numpy has no value, sympy goes on to complex numbers.
HALF_LINE = {"log", "sqrt", "asin", "acos"}


@pytest.mark.parametrize("name", list(BUILTIN))
def test_numpy_and_sympy_forms_agree_at_zero_too(name):
    operator = BUILTIN[name]
    symbols = sympy.symbols(f"a0:{operator.arity}", real=True)
    expression = operator.to_sympy(*symbols)
    for point in POINTS:
        values = [point + 0.5 * i for i in range(operator.arity)]
        with np.errstate(all="ignore"):
            ours = float(operator(*(np.array([v]) for v in values))[0])
        theirs = expression.subs(dict(zip(symbols, values, strict=True)))
        if np.isfinite(ours):
            assert ours == pytest.approx(float(theirs), rel=1e-12, abs=1e-15)
        else:
            assert name in HALF_LINE
            assert theirs.is_real is not True or not theirs.is_finite


def test_sgn_of_zero_is_zero():
    assert BUILTIN["sgn"](np.array([0.0]))[0] == 0.0


@pytest.mark.parametrize("name", list(BUILTIN))
def test_builtin_operators_are_pickled_by_name(name):
    assert pickle.loads(pickle.dumps(BUILTIN[name])) is BUILTIN[name]


def test_names_and_operators_mix():
    own = Operator("relu", lambda a: np.maximum(a, 0.0), 1)
    assert [operator.name for operator in resolve(["mul", own])] == ["mul", "relu"]


def test_a_ufunc_is_an_operator():
    (own,) = resolve([Operator("root3", np.cbrt, 1)])
    assert own(np.array([8.0]))[0] == 2.0


@pytest.mark.parametrize(
    ("entries", "error", "message"),
    [
        (["plus"], ValueError, "must name built-in operators; got 'plus'"),
        (["mul", "mul"], ValueError, "must name each operator once"),
        ([], ValueError, "must not be empty"),
        ([np.sin], TypeError, "names or Operator objects"),
        ([Operator("pick", lambda a: a[0], 1)], ValueError, "element by element"),
        ([Operator("branch", lambda a: a if a > 0 else -a, 1)], ValueError, "element by element"),
        ([Operator("wave", lambda a: np.exp(1j * a), 1)], ValueError, "complex"),
        ([Operator("relu", np.vectorize(lambda a: max(a, 0)), 1)], ValueError, "than for its elem"),
        ([Operator("two", lambda a, b: a, 1)], ValueError, "element by element"),
    ],
    ids=[
        "unknown",
        "twice",
        "none",
        "function",
        "one value",
        "branches",
        "complex",
        "rounded",
        "arity",
    ],
)
def test_bad_operators_are_named(entries, error, message):
    with pytest.raises(error, match=message):
        resolve(entries)


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        (("a b", np.sin, 1), ValueError, "must be an identifier"),
        (("lambda", np.sin, 1), ValueError, "must be an identifier"),
        ((3, np.sin, 1), TypeError, "must be a string"),
        (("f", "sin", 1), TypeError, "must be callable"),
        (("f", np.sin, 0), ValueError, "at least 1"),
        (("f", np.sin, 1, "sin"), TypeError, "must be callable"),
    ],
)
def test_bad_descriptions_are_named(arguments, error, message):
    with pytest.raises(error, match=message):
        Operator(*arguments)


def test_softsign_is_printed_as_a_quotient_with_the_number_below_the_line():
    q = sympy.Symbol("q", real=True)
    printed = BUILTIN["softsign"].to_sympy(-4.0 * q)
    assert printed == -q / (0.25 + sympy.Abs(q))
    values = np.linspace(-2.0, 2.0, 7)
    assert sympy.lambdify(q, printed)(values) == pytest.approx(BUILTIN["softsign"](-4.0 * values))
