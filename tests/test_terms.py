"""Terms: one canonical form, and one value in every view."""

import pickle

import numpy as np
import pytest
import sympy
from hypothesis import given, settings
from hypothesis import strategies as st

from pysindy_evolve.operators import BUILTIN, Operator
from pysindy_evolve.reading.text import parse
from pysindy_evolve.terms import (
    ONE,
    Product,
    Sum,
    add,
    call,
    constant,
    div,
    lowest,
    mul,
    neg,
    power,
    sub,
    variable,
)  # fmt: skip

NAMES = ("q", "v")
SYMBOLS = sympy.symbols("q v", real=True)
UNARY = (
    "sin",
    "cos",
    "tan",
    "exp",
    "abs",
    "sgn",
    "tanh",
    "cosh",
    "atan",
    "softsign",
    "neg",
    "square",
    "cube",
    "log",
    "sqrt",
)

leaves = st.one_of(
    st.sampled_from([variable(0), variable(1)]),
    st.sampled_from([-2.0, -1.0, 0.5, 1.0, 3.0]).map(constant),
)
expressions = st.recursive(
    leaves,
    lambda inner: st.one_of(
        st.builds(lambda name, a: call(BUILTIN[name], a), st.sampled_from(UNARY), inner),
        st.builds(
            lambda name, a, b: call(BUILTIN[name], a, b),
            st.sampled_from(("add", "sub", "mul", "div")),
            inner,
            inner,
        ),
    ),
    max_leaves=6,
)
values = st.sampled_from([-1.3, -0.5, 0.0, 0.7, 1.0, 2.1])


def q():
    return variable(0)


def v():
    return variable(1)


def sgn(a):
    return call(BUILTIN["sgn"], a)


def magnitude(a):
    return call(BUILTIN["abs"], a)


@pytest.mark.parametrize(
    ("expression", "name"),
    [
        (lambda: mul(q(), mul(q(), q())), "q^3"),
        (lambda: call(BUILTIN["cube"], q()), "q^3"),
        (lambda: mul(v(), sgn(v())), "abs(v)"),
        (lambda: mul(magnitude(v()), sgn(v())), "v"),
        (lambda: mul(magnitude(v()), magnitude(v())), "v^2"),
        (lambda: mul(sgn(v()), mul(sgn(v()), sgn(v()))), "sgn(v)"),
        (lambda: mul(mul(q(), q()), sgn(v())), "q^2 sgn(v)"),
        (lambda: sub(q(), q()), "0"),
        (lambda: add(q(), q()), "2 q"),
        (lambda: mul(add(q(), v()), sub(q(), v())), "q^2 - v^2"),
        (lambda: div(mul(q(), v()), q()), "v"),
        (lambda: div(q(), add(constant(0.5), q())), "q/(0.5 + q)"),
        (lambda: sgn(mul(constant(-3.0), v())), "-sgn(v)"),
        (lambda: magnitude(mul(constant(-3.0), mul(q(), v()))), "3 abs(q) abs(v)"),
        (lambda: call(BUILTIN["sin"], neg(q())), "-sin(q)"),
        (lambda: call(BUILTIN["cos"], neg(q())), "cos(q)"),
        (lambda: mul(magnitude(add(q(), v())), sgn(add(q(), v()))), "q + v"),
        (lambda: mul(add(q(), v()), power(add(q(), v()), -1)), "q/(q + v) + v/(q + v)"),
        (lambda: call(BUILTIN["exp"], constant(0.0)), "1"),
        (lambda: call(BUILTIN["sqrt"], mul(constant(4.0), mul(q(), v()))), "2 sqrt(q v)"),
        (lambda: call(BUILTIN["sqrt"], sub(constant(4.0), q())), "sqrt(4 - q)"),
        (lambda: call(BUILTIN["sqrt"], neg(q())), "sqrt(-q)"),
    ],
)
def test_an_expression_has_one_form(expression, name):
    assert expression().name(NAMES) == name


@settings(max_examples=300, deadline=None, derandomize=True)
@given(expression=expressions, a=values, b=values)
def test_numpy_and_sympy_give_the_same_value_at_zero_too(expression, a, b):
    ours = expression.evaluate(np.array([[a, b]]))[0]
    view = expression.to_sympy(SYMBOLS)
    if not np.isfinite(ours) or abs(ours) > 1e8:
        return  # such a term is rejected by the search
    with np.errstate(all="ignore"):
        theirs = sympy.lambdify(SYMBOLS, view, "numpy")(a, b)
    assert theirs == pytest.approx(ours, rel=1e-6, abs=1e-6)


@settings(max_examples=200, deadline=None, derandomize=True)
@given(one=expressions, other=expressions, a=values, b=values)
def test_arithmetic_on_sums_is_arithmetic_on_values(one, other, a, b):
    x = np.array([[a, b]])
    left, right = one.evaluate(x)[0], other.evaluate(x)[0]
    if not (np.isfinite([left, right]).all() and max(abs(left), abs(right)) < 1e4):
        return
    for build, value in ((add, left + right), (sub, left - right), (mul, left * right)):
        result = build(one, other).evaluate(x)[0]
        if np.isfinite(result):  # 1/q times q is one, but at q = 0 only where both were finite
            assert result == pytest.approx(value, rel=1e-6, abs=1e-6)


@settings(max_examples=200, deadline=None, derandomize=True)
@given(expression=expressions)
def test_terms_pickle_hash_and_compare(expression):
    copy = pickle.loads(pickle.dumps(expression))
    assert copy == expression
    assert hash(copy) == hash(expression)


@settings(max_examples=200, deadline=None, derandomize=True)
@given(expression=expressions)
def test_constants_put_back_change_nothing(expression):
    for _, term in expression.parts:
        assert term.with_constants(term.constants) == term


def test_inner_constants_are_replaced_from_left_to_right():
    ((_, term),) = div(q(), add(constant(0.5), q())).parts
    assert term.constants == (0.5,)
    assert term.with_constants([2.0]).name(NAMES) == "q/(2 + q)"


def test_a_cache_is_shared_between_terms():
    ((_, term),) = mul(q(), sgn(v())).parts
    cache = {}
    x = np.array([[2.0, -1.0]])
    assert term.evaluate(x, cache)[0] == -2.0
    assert term in cache


def test_an_operator_of_the_user_is_printed_under_its_name():
    relu = Operator("relu", lambda a: np.maximum(a, 0.0), 1)
    expression = mul(q(), call(relu, v()))
    assert expression.name(NAMES) == "q relu(v)"
    assert str(expression.to_sympy(SYMBOLS)) == "q*relu(v)"


def test_one_is_the_constant_term():
    assert Product(()) == ONE
    assert ONE.name(NAMES) == "1"
    np.testing.assert_array_equal(ONE.evaluate(np.zeros((3, 2))), np.ones(3))
    assert constant(2.0) == Sum(((2.0, ONE),))


def test_the_power_of_a_short_sum_is_multiplied_out():
    assert power(add(q(), v()), 2).name(NAMES) == "q^2 + v^2 + 2 q v"
    assert len(power(add(q(), add(v(), constant(1.0))), 4).parts) == 15


def test_powers_built_in_other_ways_are_the_same():
    base = add(q(), add(v(), constant(0.5)))
    squared = power(base, 2)
    assert mul(squared, squared) == power(squared, 2) == power(base, 4)


@pytest.mark.parametrize("exponent", [9, 40, -9])
def test_a_high_power_of_a_sum_keeps_the_sum_as_one_factor(exponent):
    raised = power(add(mul(constant(2.0), q()), mul(constant(2.0), v())), exponent)
    assert raised.name(NAMES).endswith(f"(q + v)^{abs(exponent)}")
    value = raised.evaluate(np.array([[0.7, -0.7001]]))[0]
    assert value == pytest.approx((2.0 * (0.7 - 0.7001)) ** exponent, rel=1e-12)


def test_a_long_sum_is_multiplied_out_in_full_or_not_at_all():
    polynomial = power(add(q(), constant(1.0)), 8)
    assert len(power(polynomial, 2).parts) == 17
    longer = add(polynomial, sgn(v()))  # 10 parts to the third power have 220
    cubed = power(longer, 3)
    assert [len(atom.parts) for atom, _ in cubed.parts[0][1].factors] == [10]
    other = add(polynomial, call(BUILTIN["exp"], v()))
    assert len(mul(longer, other).parts) == 1


def test_a_power_comes_back_to_what_it_was_made_of():
    base = add(q(), v())
    assert div(power(base, 60), power(base, 59)) == base
    assert power(power(base, -1), -1) == base


def test_a_power_beyond_the_largest_float_is_infinite_and_below_the_smallest_zero():
    large = mul(constant(-1e200), q())
    assert power(large, 2).parts[0][0] == np.inf
    assert power(large, 3).parts[0][0] == -np.inf
    assert power(large, -2) == Sum(())
    assert power(large, 2).to_sympy(SYMBOLS) == sympy.oo * SYMBOLS[0] ** 2


def test_the_power_of_zero():
    assert power(Sum(()), 0) == constant(1.0)
    assert power(Sum(()), 2) == Sum(())
    assert np.isnan(power(Sum(()), -1).evaluate(np.zeros((1, 2)))).all()


def test_infinity_less_infinity_is_no_number_and_no_warning():
    exponential = call(BUILTIN["exp"], q())
    difference = sub(exponential, mul(constant(2.0), exponential))
    assert difference.evaluate(np.array([[1e3, 0.0]]))[0] == -np.inf
    difference = sub(exponential, call(BUILTIN["exp"], mul(constant(2.0), q())))
    assert np.isnan(difference.evaluate(np.array([[1e3, 0.0]]))[0])


@pytest.mark.parametrize("factor", [1.0, -2.0, 1.0 / 3.0])
def test_a_sum_divided_by_a_multiple_of_itself_is_a_number(factor):
    base = add(mul(constant(0.1), q()), mul(constant(0.3), v()))
    ((value, term),) = div(mul(constant(factor), base), base).parts
    assert term == ONE
    assert value == pytest.approx(factor, rel=1e-14)


def test_sums_of_the_same_terms_in_other_shares_are_not_cancelled():
    quotient = div(add(q(), v()), add(q(), mul(constant(1.001), v())))
    assert quotient.variables == {0, 1}


@pytest.mark.parametrize(
    ("long", "short"),
    [
        ("q**4/(0.5*q**3 + q**4)", "q/(0.5 + q)"),
        ("1/(2 + 1/q)", "q/(0.5 + q)"),
        ("v/(q*v + q**2*v)", "1/(q (1 + q))"),
        ("q/(0.5 + q)", "q/(0.5 + q)"),
        ("q/(v + q**2)", "q/(v + q^2)"),
    ],
)
def test_fractions_are_brought_to_lowest_terms(long, short):
    ((_, term),) = parse(long, ("q", "v")).known.parts
    assert lowest(term).name(("q", "v")) == short


@pytest.mark.parametrize(
    ("text", "one"),
    [
        ("q*exp(q)**3*exp(-1.9*q)", "q exp(1.1 q)"),
        ("exp(0.5 + 2*q)", "1.649 exp(2 q)"),
        ("exp(q)*exp(-q)", "1"),
        ("exp(q)**2*exp(v)", "exp(2 q + v)"),
    ],
)
def test_exponentials_are_one_and_hold_no_constant(text, one):
    assert parse(text, ("q", "v")).known.name(("q", "v")) == one


def test_a_constant_that_overflows_stays_in_its_exponential():
    assert parse("exp(q - 1000)", ("q",)).known.name(("q",)) == "exp(-1000 + q)"
