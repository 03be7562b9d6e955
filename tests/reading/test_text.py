"""Text and sympy to right-hand sides that are linear in their free parameters."""

import math

import numpy as np
import pytest
import sympy
from hypothesis import given, settings
from hypothesis import strategies as st

from pysindy_evolve.operators import Operator
from pysindy_evolve.reading.text import parse

NAMES = ("q", "v", "F", "t")
OWNER = 'DeclaredModel(equations["v"]=...)'


def known_value(text, **known):
    """Value of a text without free parameters at q = 0.7, v = -1.3, F = 2, t = 5."""
    side = parse(text, NAMES, known=known)
    assert side.parameters == ()
    return side.known.evaluate(np.array([[0.7, -1.3, 2.0, 5.0]]))[0]


def test_free_parameters_keep_the_order_of_the_text_and_their_terms():
    side = parse("-k*q - c*v + b*F + 3.0", NAMES)
    assert [(name, part.name(NAMES)) for name, part in side.free] == [
        ("k", "-q"),
        ("c", "-v"),
        ("b", "F"),
    ]
    assert side.known.name(NAMES) == "3"


def test_parameter_that_occurs_twice_is_one_parameter():
    side = parse("k*(q + v*sgn(v)) + k/2", NAMES)
    assert [(name, part.name(NAMES)) for name, part in side.free] == [("k", "0.5 + q + abs(v)")]


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("-q^2", -0.49),
        ("-q**2", -0.49),
        ("2^3^2", 512.0),
        ("2*q^-1", 2 / 0.7),
        ("6/2/3*q", 0.7),
        ("1 - 2 - 3*v - 4", -5 + 3.9),
        ("q**0.5", 0.7**0.5),
        ("q**1.5", 0.7**1.5),
        ("q**-1.5", 0.7**-1.5),
        ("q**(1/3)", 0.7 ** (1 / 3)),
        ("2**q", 2**0.7),
        ("F^0", 1.0),
        ("pi*q", math.pi * 0.7),
        ("1.5e-5*F + .5", 3e-5 + 0.5),
        ("Abs(v) + sign(v) + ln(F)", 1.3 - 1 + math.log(2)),
        ("square(v) - cube(v)", 1.69 + 2.197),
        ("atan(v) + arcsin(q) - cosh(v)", math.atan(-1.3) + math.asin(0.7) - math.cosh(1.3)),
        ("(q + v)**40", 0.6**40),
        ("q\n  + v", -0.6),
        ("q/(1 + F)*v", 0.7 / 3 * -1.3),
        ("exp(-(v/0.1)^2)", math.exp(-169)),
    ],
)
def test_text_has_the_value_of_the_written_formula(text, value):
    assert known_value(text) == pytest.approx(value, rel=1e-12)


def test_known_constants_are_substituted_wherever_they_stand():
    assert known_value("-(k/m)*q + sin(w*t)", k=3.0, m=2.0, w=0.5) == pytest.approx(
        -1.5 * 0.7 + math.sin(2.5)
    )


def test_names_of_python_keywords_are_plain_names():
    assert parse("lambda*q + in", NAMES).parameters == ("lambda", "in")


def test_operators_of_the_user_are_called():
    relu = Operator("relu", lambda a: np.maximum(a, 0.0), 1)
    side = parse("relu(-v) + relu(2)", NAMES, operators=[relu])
    assert side.known.evaluate(np.array([[0.0, -1.5, 0.0, 0.0]]))[0] == 3.5


def test_variables_may_lie_in_any_columns():
    side = parse("a - b", {"a": 3, "b": 1})
    assert side.known.evaluate(np.array([[0.0, 1.0, 0.0, 5.0]]))[0] == 4.0


def test_sympy_expressions_keep_full_precision():
    q, v, k = sympy.symbols("q v k", real=True)
    expression = k * q - sympy.sign(v) / 3 + sympy.Float(0.1234567890123456) * sympy.E * v
    side = parse(expression, NAMES)
    assert side.parameters == ("k",)
    value = side.known.evaluate(np.array([[0.7, -1.3, 0.0, 0.0]]))[0]
    assert value == pytest.approx(1 / 3 - 0.1234567890123456 * math.e * 1.3, rel=1e-15)


def test_number_is_a_known_constant():
    assert parse(-9.81, NAMES).known.evaluate(np.zeros((1, 4)))[0] == -9.81


def test_parameter_that_cancels_is_dropped():
    assert parse("a*q - a*q + v", NAMES).parameters == ()


def test_long_sums_are_read_without_recursion():
    assert known_value("+".join(["q"] * 2000)) == pytest.approx(1400.0)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("-(k/m)*q", r"linear in its free parameters; got a division by 'm'.*`known`, or name"),
        ("a*(q - q0)", r"linear in its free parameters; got the product of 'a' and 'q0'"),
        (
            "sin(w*t)",
            r"linear in its free parameters; got 'w' inside .*a constant, give it in `known`",
        ),
        ("k**2*q", r"linear in its free parameters; got 'k' inside"),
        ("", r"must not be empty; got ''"),
        (" \n", r"must not be empty"),
        ("2q", r"operator between two factors; got '2' followed by 'q' at character 2"),
        ("q v", r"operator between two factors; got 'q' followed by 'v'"),
        ("(q)(v)", r"operator between two factors; got '\)' followed by '\('"),
        ("q +", r"must be an expression; got a syntax error at character 4"),
        ("q - * v", r"must be an expression; got a syntax error at character 5"),
        ("sin(q", r"must be an expression; got a syntax error at character 4"),
        ("q)", r"must be an expression; got a syntax error at character 2"),
        ("q, v", r"must be an expression"),
        ("()", r"must be an expression"),
        ("sin(**q)", r"must be an expression"),
        ("sin(*q)", r"must be an expression"),
        ("f(q)", r"must call known functions; got f\(...\) at character 1.*Functions: square"),
        ("sin(q, v)", r"must give sin 1 argument\(s\); got 2"),
        ("sin*q", r"must call its functions; got 'sin'"),
        ("q**v", r"must have constant exponents"),
        ("v = -q", r"got '=' at character 3 .*right-hand side alone"),
        ("q.__class__", r"must be an expression; got '.' at character 2"),
        ("__import__*q", r"must use plain names; got '__import__'"),
        ("__import__('os').system('ls')", r"must be an expression; got \"'\""),
        ("lambda x: x", r"operator between two factors"),
        ("q if v else F", r"operator between two factors"),
        ("[q for q in v]", r"must be an expression; got '\['"),
        ("q[0]", r"must be an expression; got '\['"),
        ("'text'", r"must be an expression"),
        ("q < v", r"must be an expression; got '<'"),
        ("q := v", r"must be an expression; got ':'"),
        ("q // v", r"must be an expression; got a syntax error"),
        ("q\x00", r"must be an expression"),
        ("9**9**9", r"must have finite values"),
        ("1e999", r"must hold finite numbers; got 1e999"),
        ("1e200*1e200*q", r"must have finite values"),
        ("1/0", r"must have finite values"),
        ("q/(v - v)", r"must have finite values"),
        ("log(-1)*q", r"must have finite values"),
        ("(-2)**0.5", r"must have finite values"),
        ("q**999999", r"must stay below"),
        ("((q**9)**9)**9", r"must stay below"),
        ("((((q+v)**9)**9)**9)**9", r"must (stay below|have finite)"),
        ("(" * 100 + "q" + ")" * 100, r"must stay below .* 30 levels"),
        ("-" * 1000 + "q", r"must stay below"),
        ("2**" * 1000 + "q", r"must stay below"),
        ("+".join(f"sin({i}*q)" for i in range(2, 900)), r"must stay below"),
        ("q+" * 10_000 + "q", r"must stay below 5000 symbols"),
    ],
)
def test_anything_else_is_an_error_that_points_at_it(text, message):
    with pytest.raises(ValueError, match=message) as caught:
        parse(text, NAMES, owner=OWNER)
    assert str(caught.value).startswith(OWNER)


@pytest.mark.parametrize("text", [None, True, ["q"], object(), 1j])
def test_other_types_are_a_type_error(text):
    with pytest.raises(TypeError, match="must be text, a sympy expression or a number; got"):
        parse(text, NAMES)


@pytest.mark.parametrize(
    ("expression", "message"),
    [
        (sympy.Symbol("x 0"), "must have identifiers as symbols; got 'x 0'"),
        (sympy.I * sympy.Symbol("q"), "must be real and finite"),
        (sympy.oo, "must be real and finite"),
        (sympy.Function("q")(sympy.Symbol("t")), "must call known functions"),
        (sympy.Heaviside(sympy.Symbol("q")), "must call known functions"),
    ],
)
def test_sympy_outside_the_whitelist_is_an_error(expression, message):
    with pytest.raises(ValueError, match=message):
        parse(expression, NAMES)


@pytest.mark.parametrize("value", [math.nan, math.inf, "3", None])
def test_known_constants_must_be_finite_numbers(value):
    with pytest.raises(ValueError, match=r"known\['k'\]=\.\.\.\) must be a finite number; got"):
        parse("k*q", NAMES, known={"k": value})


PIECES = [*NAMES, "k", "c", "sin", "log", "sgn", "abs", "sqrt", "2", "0", ".5", "1e300", "pi"]
PIECES += ["+", "-", "*", "/", "**", "^", "(", ")", "(", ")", ",", " ", "__a", "lambda", ".", "'"]


def parses_or_complains(text):
    try:
        side = parse(text, NAMES, owner=OWNER)
    except ValueError as error:
        assert str(error).startswith(f"{OWNER} must ")  # noqa: PT017
        return
    with np.errstate(all="ignore"):  # nothing is protected: q/(q - v) has no value at q = v
        assert side.known.evaluate(np.ones((2, 4))).shape == (2,)
    assert all(isinstance(name, str) for name in side.parameters)


@settings(max_examples=400, deadline=None, derandomize=True)
@given(st.lists(st.sampled_from(PIECES), max_size=40).map("".join))
def test_any_pieces_end_in_a_result_or_the_error(text):
    parses_or_complains(text)


@settings(max_examples=200, deadline=None, derandomize=True)
@given(st.text(max_size=60))
def test_any_text_ends_in_a_result_or_the_error(text):
    parses_or_complains(text)


@st.composite
def expressions(draw, depth=4):
    if depth == 0 or draw(st.integers(0, 3)) == 0:
        return draw(st.sampled_from([*NAMES, "k", "c", "2", "0", "0.5", "-3"]))
    kind = draw(st.sampled_from(["+", "-", "*", "/", "**", "call", "power"]))
    one = draw(expressions(depth=depth - 1))
    if kind == "call":
        return f"{draw(st.sampled_from(['sin', 'log', 'sgn', 'abs', 'exp', 'sqrt']))}({one})"
    if kind == "power":
        return f"({one})**{draw(st.sampled_from(['2', '3', '0.5', '-1', '7', '20']))}"
    return f"({one}){kind}({draw(expressions(depth=depth - 1))})"


@settings(max_examples=300, deadline=None, derandomize=True)
@given(expressions())
def test_any_expression_ends_in_a_result_or_the_error(text):
    parses_or_complains(text)


def python_value(text, **names):
    functions = {"sin": np.sin, "log": np.log, "sgn": np.sign, "abs": np.abs, "exp": np.exp}
    functions |= {"sqrt": np.sqrt} | {name: np.float64(value) for name, value in names.items()}
    with np.errstate(all="ignore"):
        return eval(text, {"__builtins__": {}}, functions)  # noqa: S307 - of this test's own making


@settings(max_examples=300, deadline=None, derandomize=True)
@given(expressions(depth=3))
def test_text_means_what_python_means_by_it(text):
    values = {"q": 0.7, "v": 1.3, "F": 2.1, "t": 5.2}
    try:
        side = parse(text, NAMES)
        expected = complex(python_value(text, **values, k=1.9, c=-0.4))
        nearby = {name: value * (1 + 1e-13) for name, value in values.items()}
        rounding = abs(complex(python_value(text, **nearby, k=1.9, c=-0.4)) - expected)
    except (ValueError, ZeroDivisionError, OverflowError):
        return
    point = np.array([list(values.values())])
    factors = {"k": 1.9, "c": -0.4}
    with np.errstate(all="ignore"):
        found = side.known.evaluate(point)[0] + sum(
            factors[name] * part.evaluate(point)[0] for name, part in side.free
        )
    # A difference of rounding is not ours: sin(t**20) turns by many radians for it.
    if expected.imag == 0.0 and abs(expected) < 1e6 and rounding < 1e-8:
        assert found == pytest.approx(expected.real, rel=1e-6, abs=1e-6)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("min(q, 0.2)", 0.2),
        ("max(q, 0.2)", 0.7),
        ("min(max(v, -1), 1)", -1.0),
        ("max(q, v, F)", 2.0),
        (sympy.Max(sympy.Symbol("q"), 3 * sympy.Symbol("F")), 6.0),
    ],
)
def test_limits_may_be_written_with_min_and_max(text, value):
    assert known_value(text) == pytest.approx(value)


def test_a_limit_must_not_hold_a_free_parameter():
    with pytest.raises(ValueError, match="free parameter"):
        parse("min(q, limit)", NAMES)


@pytest.mark.parametrize("power", [0.5, 0.6, 1.5])
def test_a_power_of_what_is_never_negative_has_a_value_everywhere(power):
    side = parse(f"max(0.7*q - 0.3, 0)**{power}", NAMES)  # 0.35 q - 0.15 + |0.35 q - 0.15| rounds
    q = np.random.default_rng(0).uniform(-2.0, 2.0, 4000)
    values = side.known.evaluate(np.column_stack([q, 0 * q, 0 * q, 0 * q]))
    np.testing.assert_allclose(values, np.maximum(0.7 * q - 0.3, 0.0) ** power, atol=1e-9)
