"""Sympy, text, LaTeX and functions of arrays: the same numbers in every view."""

import math
import pickle
from types import SimpleNamespace

import numpy as np
import pysindy as ps
import pytest
import sympy
from hypothesis import given, settings
from hypothesis import strategies as st
from sklearn.exceptions import NotFittedError

from pysindy_evolve import export, terms
from pysindy_evolve.equations import Equations
from pysindy_evolve.operators import BUILTIN, Operator
from pysindy_evolve.reading.text import parse

FRICTION = "-1.1*v - 691.92*q - 2.37e6*q^3 - 2.93*sgn(v) - 7.63e3*q^2*sgn(v) - 1.02*zdd"


def equations_of(texts, states, inputs=(), operators=()):
    """Equations from the text of each right-hand side."""
    names = (*states, *inputs, "t")
    sides = [{p: c for c, p in parse(text, names, operators=operators).known.parts}
             for text in texts]  # fmt: skip
    columns = tuple(dict.fromkeys(term for side in sides for term in side))
    coef = np.array([[side.get(term, 0.0) for term in columns] for side in sides])
    return Equations(columns, coef.reshape(len(sides), len(columns)), tuple(states), tuple(inputs))


@pytest.fixture
def friction():
    return equations_of(["v", FRICTION], ("q", "v"), ("zdd",))


@pytest.fixture
def fitted():
    """A fitted PySINDy model with inputs, custom functions and products."""
    rng = np.random.default_rng(1)
    library = ps.GeneralizedLibrary(
        [
            ps.PolynomialLibrary(degree=2),
            ps.CustomLibrary([lambda q: np.sign(q), lambda q: q * np.abs(q)]),
            ps.FourierLibrary(),
        ],
        tensor_array=[[1, 1, 0]],
    )
    model = ps.SINDy(feature_library=library, optimizer=ps.STLSQ(threshold=0.0, alpha=1e-3))
    x, u = rng.normal(size=(300, 2)), rng.normal(size=(300, 1))
    return model.fit(x, t=0.1, u=u, x_dot=rng.normal(size=(300, 2)), feature_names=["q", "v", "F"])


def samples(n_columns, seed=0):
    """Random rows, and rows with zeros."""
    x = np.random.default_rng(seed).normal(size=(40, n_columns))
    x[:10] *= np.random.default_rng(seed).integers(0, 2, size=(10, n_columns))
    x[0] = 0.0
    return x


def test_sympy_function_and_predict_agree_at_zeros_too(fitted):
    x, u = samples(2), samples(1, 1)
    expected = np.asarray(fitted.predict(x, u=u))
    np.testing.assert_allclose(
        export.to_callable(fitted)(0.0, x, u), expected, rtol=1e-9, atol=1e-10
    )
    symbols = sympy.symbols("q v F", real=True)
    function = sympy.lambdify(symbols, export.to_sympy(fitted), "numpy")
    found = np.column_stack([np.broadcast_to(side, len(x)) for side in function(*x.T, *u.T)])
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-10)


def test_sympy_of_the_friction_law_is_the_written_equation(friction):
    q, v, zdd = sympy.symbols("q v zdd", real=True)
    expected = -1.1 * v - 691.92 * q - 2370000 * q**3 - 2.93 * sympy.sign(v)
    expected += -7630 * q**2 * sympy.sign(v) - 1.02 * zdd
    assert export.to_sympy(friction) == [v, expected]
    assert sympy.expand(export.to_sympy(friction)[1]) == expected


def test_like_terms_of_a_library_are_collected():
    rng = np.random.default_rng(0)
    library = ps.IdentityLibrary() * ps.CustomLibrary([lambda q: np.sign(q), lambda q: 2 * q])
    x = rng.normal(size=(100, 2))
    x_dot = np.column_stack([np.abs(x[:, 0]), 3 * x[:, 0] * x[:, 1]])
    model = ps.SINDy(feature_library=library, optimizer=ps.STLSQ(threshold=0.1, alpha=1e-9))
    model.fit(x, t=0.1, x_dot=x_dot, feature_names=["q", "v"])
    q, v = sympy.symbols("q v", real=True)
    assert export.to_sympy(model, digits=6) == [sympy.Abs(q), 3 * q * v]


def test_digits_round_to_significant_ones_inside_terms_too():
    equations = equations_of(["2.183456e6*q + 1.54321e-5*sin(2.123456*q)"], ("q",))
    q = sympy.Symbol("q", real=True)
    assert export.to_sympy(equations, digits=3) == [2180000 * q + 1.54e-5 * sympy.sin(2.12 * q)]
    assert export.to_sympy(equations)[0].coeff(q) == 2183456


def test_text_is_what_one_writes_in_a_report(friction):
    assert export.format_equations(friction) == (
        "q' = v\nv' = -691.9 q - 1.1 v - 1.02 zdd - 2.93 sgn(v) - 2.37e6 q^3 - 7630 q^2 sgn(v)"
    )


@pytest.mark.parametrize(
    ("text", "printed"),
    [
        ("0", "q' = 0"),
        ("2.18e6", "q' = 2.18e6"),
        ("1.5e-5 - q", "q' = -q + 1.5e-5"),
        ("2.5 + q/(0.25 + q)", "q' = q/(q + 0.25) + 2.5"),
        ("3*(q*abs(q)) - abs(q)", "q' = -|q| + 3 q |q|"),
        ("exp(-(q/0.1)^2)*sgn(q)", "q' = exp(-100 q^2) sgn(q)"),
        ("1234567*sin(0.000012345*q)", "q' = 1.235e6 sin(1.234e-5 q)"),
        ("2*(q + 1)^60", "q' = 2 (q + 1)^60"),
    ],
)
def test_text_of_large_small_and_inner_numbers(text, printed):
    assert export.format_equations(equations_of([text], ("q",))) == printed


def test_more_digits_are_printed_when_asked_for():
    equations = equations_of(["1.23456789*q + sin(9.87654321*q)"], ("q",))
    assert "1.2345679 q + sin(9.8765432 q)" in export.format_equations(equations, digits=8)
    assert "1.23456789 q + sin(9.87654321 q)" in export.format_equations(equations, digits=None)


@pytest.mark.parametrize(
    ("value", "digits", "printed"),
    [
        (2.18e6, 4, "2.18e6"),
        (1.5e-5, 4, "1.5e-5"),
        (-691.92, 4, "-691.9"),
        (9810.0, 4, "9810"),
        (12345.6, 4, "1.235e4"),
        (0.1 + 0.2, None, "0.30000000000000004"),
        (1e22, None, "1e22"),
        (3.0, None, "3"),
        (0.0, 4, "0"),
    ],
)
def test_numbers_have_significant_digits(value, digits, printed):
    assert export.format_number(value, digits) == printed


def test_latex_has_dots_powers_of_ten_and_sgn(friction):
    latex = export.to_latex(friction)
    assert latex.startswith("\\begin{aligned}\n\\dot{q} &= v \\\\\n\\dot{v} &= -691.9 q - 1.1 v")
    assert r"- 2.37 \cdot 10^{6} q^{3}" in latex
    assert r"- 7630 q^{2} \operatorname{sgn}\left(v\right)" in latex
    assert r"- 1.02 \mathrm{zdd}" in latex


@pytest.mark.parametrize(
    ("text", "latex"),
    [
        ("1e9*q + 1.5e-5", r"\dot{q} = 10^{9} q + 1.5 \cdot 10^{-5}"),
        ("q/(0.5 + q^2)", r"\dot{q} = \frac{q}{q^{2} + 0.5}"),
        ("sgn(q)^2*q^2 - 1e-7*abs(q)", r"\dot{q} = -10^{-7} \left|{q}\right| + q^{2}"),
        ("sin(1e-6*q)", r"\dot{q} = \sin{\left(10^{-6} q \right)}"),
    ],
)
def test_latex_of_single_equations(text, latex):
    assert export.to_latex(equations_of([text], ("q",))) == latex


def test_latex_braces_are_balanced_for_every_term(fitted):
    latex = export.to_latex(fitted)
    assert latex.count("{") == latex.count("}")
    assert latex.count(r"\left") == latex.count(r"\right")


@pytest.mark.parametrize("names", [("x 0", "lambda"), ("t'", "x_1^2"), ("α", "q+v"), ("E", "I")])
def test_any_name_works_in_every_view(names):
    q, v = terms.variable(0), terms.variable(1)
    term = terms.mul(terms.mul(q, q), terms.call(BUILTIN["sgn"], v)).parts[0][1]
    equations = Equations((term,), np.array([[0.0], [-2.5]]), names)
    symbols = [sympy.Symbol(name, real=True) for name in names]
    assert export.to_sympy(equations) == [0, -2.5 * symbols[0] ** 2 * sympy.sign(symbols[1])]
    assert "-2.5" in export.format_equations(equations)
    assert export.to_latex(equations).count(r"\dot") == 2
    assert export.to_callable(equations)(0.0, [2.0, -1.0])[1] == 10.0
    for language in ("python", "c", "matlab", "julia", "modelica"):
        assert "2.5" in export.to_code(equations, language)


def test_callable_takes_one_sample_or_many(friction):
    f = export.to_callable(friction)
    x, u = samples(2), samples(1, 1)
    many = f(0.0, x, u)
    assert many.shape == (40, 2)
    np.testing.assert_array_equal(f(0.0, x, u[:, 0]), many)
    np.testing.assert_array_equal(f(0.0, x[3], u[3]), many[3])
    np.testing.assert_array_equal(f(0.0, x[3], u[3, 0]), many[3])
    np.testing.assert_array_equal(f(0.0, x, 0.5), f(0.0, x, np.full(40, 0.5)))


def test_callable_gets_time():
    f = export.to_callable(equations_of(["q*sin(3*t)"], ("q",)))
    assert f(2.0, [1.5])[0] == pytest.approx(1.5 * math.sin(6.0))
    assert f([1.0, 2.0], [[1.0], [1.0]])[:, 0] == pytest.approx(np.sin([3.0, 6.0]))


def test_callable_of_a_system_without_terms_is_zero():
    f = export.to_callable(equations_of(["0", "0"], ("q", "v")))
    np.testing.assert_array_equal(f(0.0, [1.0, 2.0]), [0.0, 0.0])


def test_callable_pickles(friction):
    f = pickle.loads(pickle.dumps(export.to_callable(friction)))
    np.testing.assert_array_equal(
        f(0.0, [1.0, -1.0], [0.5]), export.to_callable(friction)(0.0, [1.0, -1.0], [0.5])
    )


def test_callable_runs_operators_of_the_user():
    relu = Operator("relu", lambda a: np.maximum(a, 0.0), 1)
    equations = equations_of(["-2*relu(q)"], ("q",), operators=[relu])
    assert export.to_callable(equations)(0.0, [3.0])[0] == -6.0
    assert export.to_sympy(equations)[0] == -2 * sympy.Function("relu", real=True)(
        sympy.Symbol("q", real=True)
    )


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((0.0, [1.0]), r"\(x=...\) must be of shape \(2,\) or \(n_samples, 2\); got shape \(1,\)"),
        ((0.0, [1.0, 2.0]), r"\(u=...\) must be of shape \(1,\) or \(1, 1\); got None"),
        ((0.0, [1.0, 2.0], [1.0, 2.0]), r"\(u=...\) must be .* got shape \(2,\)"),
        (([0.0, 1.0], [1.0, 2.0], 1.0), r"\(t=...\) must be a number or of shape \(1,\)"),
    ],
)
def test_callable_names_the_shape_that_does_not_fit(friction, arguments, message):
    with pytest.raises(ValueError, match=message):
        export.to_callable(friction)(*arguments)


def test_reports_and_equations_are_read_like_models(fitted):
    direct = export.to_sympy(fitted)
    assert export.to_sympy(SimpleNamespace(model=fitted)) == direct


VIEWS = [export.to_sympy, export.format_equations, export.to_latex, export.to_code]
VIEWS += [export.to_callable, export.plot_tree]


@pytest.mark.parametrize("view", VIEWS)
def test_every_view_names_itself_in_errors(view):
    with pytest.raises(NotFittedError, match=rf"^{view.__name__}\(model=...\) must be fitted"):
        view(ps.SINDy())
    with pytest.raises(TypeError, match=rf"^{view.__name__}\(model=...\) must be a fitted pysindy"):
        view("model")
    twice = equations_of(["-1.0"], ("q",))
    twice = Equations(twice.terms, np.ones((2, 1)), ("q", "q"))
    with pytest.raises(ValueError, match=r"name of its own for each variable; got 'q' twice"):
        view(twice)


@pytest.mark.parametrize("digits", [0, -1, 2.5])
def test_digits_must_be_a_positive_integer(friction, digits):
    with pytest.raises(ValueError, match=r"to_latex\(digits=...\) must be a positive integer"):
        export.to_latex(friction, digits=digits)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(
    st.lists(
        st.tuples(
            st.floats(-1e7, 1e7, allow_subnormal=False),
            st.sampled_from(["q", "v", "q*v", "sgn(v)", "q^3", "abs(q)*v", "sin(2*q+1)", "1",
                             "q/(2 + v^2)", "tanh(v/0.1)", "sqrt(abs(q))"]),
        ),
        max_size=8,
    ),
    st.tuples(st.sampled_from([0.0, 0.7, -1.3]), st.sampled_from([0.0, 2.0, -0.1])),
)  # fmt: skip
def test_any_equation_has_the_same_value_in_numpy_sympy_and_text(pairs, point):
    text = " + ".join(f"({c!r})*({term})" for c, term in pairs) or "0"
    equations = equations_of([text, "v"], ("q", "v"))
    value = export.to_callable(equations)(0.0, point)[0]
    q, v = sympy.symbols("q v", real=True)
    by_sympy = float(export.to_sympy(equations)[0].subs({q: point[0], v: point[1]}))
    printed = export.format_equations(equations, digits=None).split("\n")[0]
    printed = printed.removeprefix("q' = ").replace("|q|", "abs(q)").replace(" - ", "-")
    again = parse(_with_stars(printed.replace(" + ", "+")), ("q", "v")).known
    by_text = again.evaluate(np.array([point]))[0]
    scale = sum(abs(c) for c, _ in pairs) + 1.0
    assert by_sympy == pytest.approx(value, rel=1e-9, abs=1e-9 * scale)
    assert by_text == pytest.approx(value, rel=1e-9, abs=1e-9 * scale)


def _with_stars(text):
    """Write the spaces that stand for products as signs."""
    inner = text.replace("+ ", "+").replace(" +", "+").replace("- ", "-")
    return inner.replace(" ", "*")


@pytest.mark.parametrize("show", [export.format_equations, export.to_latex])
def test_the_sign_of_an_odd_function_stands_before_its_coefficient(show):
    turned = equations_of(["3*tanh(1 - 2*v - q)"], ("q", "v"))
    assert show(turned) == show(equations_of(["-3*tanh(2*v + q - 1)"], ("q", "v")))
    assert "(-" not in show(turned)


@pytest.mark.parametrize(
    ("side", "shown"),
    [
        ("2*q - 24/v", "2 q - 24/v"),
        ("1/v", "1/v"),
        ("3/q^2", "3/q^2"),
        ("1/q^2", "1/q^2"),
    ],
)
def test_a_coefficient_stands_above_the_line_of_a_reciprocal(side, shown):
    printed = export.format_equations(equations_of([side], ("q", "v")))
    assert printed.endswith(f" = {shown}")
