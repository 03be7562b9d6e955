"""What a term with a sum inside may stand for is offered beside it."""

import numpy as np

from pysindy_evolve.breeding.relatives import product_alternatives
from pysindy_evolve.operators import BUILTIN, resolve
from pysindy_evolve.terms import add, call, constant, div, mul, only_term, power, variable

Q, V = variable(0), variable(1)
SGN = BUILTIN["sgn"]
OPERATORS = resolve(("add", "mul", "div", "sgn"))


def names(equation, operators=OPERATORS):
    return [
        one.name(["q", "v"])
        for one in product_alternatives([only_term(e) for e in equation], operators)
    ]


def test_a_quotient_of_a_sum_brings_the_products_it_stands_for():
    alias = div(constant(1.0), add(Q, call(SGN, V)))
    found = names([V, alias])
    assert "q^2 sgn(v)" in found
    assert len(found) == len(set(found))
    q = np.random.default_rng(0).uniform(-0.03, 0.03, 400)
    x = np.column_stack([q, np.random.default_rng(1).normal(size=400)])
    product = only_term(mul(power(Q, 2), call(SGN, V))).evaluate(x)
    others = [only_term(e).evaluate(x) for e in (alias, Q, call(SGN, V))]
    left = product - np.column_stack(others) @ np.linalg.lstsq(np.column_stack(others), product)[0]
    assert np.std(left) < 0.05 * np.std(product)


def test_a_sign_of_a_sum_brings_the_signs_of_its_variables():
    found = names([call(SGN, add(V, constant(0.003)))])
    assert "sgn(v)" in found


def test_plain_products_bring_nothing():
    assert names([V, mul(power(Q, 2), call(SGN, V)), power(Q, 3)]) == []


def test_without_multiplication_nothing_is_brought():
    alias = div(constant(1.0), add(Q, call(SGN, V)))
    assert names([alias], resolve(("add", "div", "sgn"))) == []


def test_no_product_is_one_but_at_zero():
    found = names([div(constant(1.0), add(Q, call(SGN, V)))])
    assert not [name for name in found if "sgn(v)^2" in name]
    assert "1" not in found
