"""Small terms that a search begins with."""

import re

import numpy as np
import pytest

from pysindy_evolve.breeding.dictionary import Problem
from pysindy_evolve.loop.growth.naming import without_signs
from pysindy_evolve.loop.growth.seeds import screened, small_terms, varied
from pysindy_evolve.operators import BUILTIN, resolve
from pysindy_evolve.terms import ONE, call, mul, variable

NAMES = ("q", "v")


@pytest.fixture
def x():
    return np.random.default_rng(0).normal(size=(400, 2)) * [0.5, 2.0]


def small_names(operators, x):
    return [term.name(NAMES) for term in small_terms(resolve(operators, "test"), x)]


def test_products_of_two_functions_are_all_there(x):
    found = small_names(("mul", "abs", "sgn", "sqrt"), x)
    assert {"q", "abs(v)", "sgn(v) sqrt(abs(v))", "q abs(v)", "abs(q) sgn(v)", "v^2"} <= set(found)
    assert len(set(found)) == len(found)


def test_numbers_in_curved_functions_follow_the_size_of_the_variable(x):
    found = small_terms(resolve(("mul", "tanh"), "test"), x)
    inside = [term.constants[0] for term in found if term.name(NAMES).startswith("tanh")]
    sizes = np.sqrt(np.mean(x**2, axis=0))
    assert min(inside) == pytest.approx(0.5 / sizes[1])
    assert max(inside) == pytest.approx(3.0 / sizes[0])
    assert all(term.name(NAMES).count("tanh") <= 1 for term in found)


def test_what_decays_with_a_variable_is_there_as_well_as_what_grows(x):
    found = small_terms(resolve(("mul", "exp"), "test"), x)
    rates = sorted(
        t.constants[0] for t in found if t.variables == {0} and len(t.factors) == 1 and t.constants
    )
    assert len(rates) == 6
    assert rates == [-rate for rate in reversed(rates)]


def test_without_products_there_are_functions_only(x):
    assert small_names(("abs", "sgn"), x) == [
        "q", "abs(q)", "sgn(q)", "v", "abs(v)", "sgn(v)",
    ]  # fmt: skip


def test_magnitude_and_sign_of_what_keeps_its_sign_are_nothing_new(x):
    kelvin = x + np.array([10.0, 0.0])
    assert small_names(("abs", "sgn"), kelvin) == ["q", "v", "abs(v)", "sgn(v)"]


def test_only_what_keeps_away_from_zero_may_stand_below_the_line(x):
    gap = 1.0 - 0.2 * np.tanh(x[:, 0])
    near = np.abs(x[:, 1]) + 0.01  # keeps its sign, but comes too close
    found = small_names(("mul", "div"), np.column_stack([gap, near]))
    assert {"1/q", "1/q^2", "v/q"} <= set(found)
    assert not {"1", "1/v", "q/v"} & set(found)
    assert not any("/" in name for name in small_names(("mul",), gap[:, None]))


def test_the_term_that_explains_most_beside_the_fixed_columns_comes_first(x):
    rng = np.random.default_rng(1)
    root = np.sign(x[:, 1]) * np.sqrt(np.abs(x[:, 1]))
    target = 30.0 * x[:, 0] + root + 0.1 * rng.standard_normal(len(x))
    terms = small_terms(resolve(("mul", "abs", "sgn", "sqrt"), "test"), x)
    first = screened(Problem(x, target, x[:, :1]), terms, 3)
    assert first[0].name(NAMES) == "sgn(v) sqrt(abs(v))"
    assert len(first) == 3
    alone = screened(Problem(x, target, x[:, :0]), terms, 3)
    assert alone[0].name(NAMES) == "q"


THRUST, TIME = variable(2), variable(3)


def varied_names(operators, declared):
    """Return names of declared terms of a tilt, a height that stays above zero, and a thrust."""
    x = np.random.default_rng(0).uniform([-0.4, 0.5, -1.0], [0.4, 2.0, 1.0], (400, 3))
    found = varied(declared, resolve(operators, "test"), x)
    assert len(set(found)) == len(found)
    return [term.name(("a", "z", "T", "t")) for term in found]


def only(expression):
    ((_, term),) = expression.parts
    return term


def test_declared_terms_are_varied_by_one_variable():
    lift = only(mul(THRUST, call(BUILTIN["cos"], variable(0))))
    found = varied_names(("mul", "div", "abs", "sgn", "sqrt", "tanh"), [lift])
    assert {"T cos(a)/z", "T cos(a)/z^2", "z T cos(a)", "z^2 T cos(a)", "T abs(a) cos(a)"} <= set(
        found
    )
    assert all("tanh" not in name for name in found)
    assert not any("/a" in name or "/T" in name for name in found)  # these cross zero
    plain = [name for name in found if " + " not in name]  # none of a sum below the line
    assert all("cos(a)" in name for name in plain)
    assert len(plain) == 15


def test_what_is_below_the_line_keeps_away_from_zero_and_may_stand_alone():
    found = varied_names(("mul", "div"), [only(THRUST)])
    gaps = [name for name in found if name.startswith("T/(-") and name.endswith("a)^2")]
    places = [float(re.findall(r"-(\d\.\d+)", name)[0]) for name in gaps]
    assert places
    assert min(places) > 0.6  # the tilt goes to 0.4, by 0.8 in all
    hills = [name for name in found if name.startswith("z^2/(")]
    assert len(hills) == 3
    assert not any("/(" in name for name in varied_names(("mul",), [only(THRUST)]))


def test_what_saturates_may_be_missing_times_any_variable():
    names = varied_names(("mul", "div"), [only(THRUST)])
    assert len([name for name in names if re.fullmatch(r"a z\^2/\(.* \+ z\^2\)", name)]) == 3


def test_lengths_of_a_spring_whose_end_moves_beside_it_are_below_the_line():
    spring = only(variable(0))
    lengths = [name for name in varied_names(("mul", "div", "sqrt"), [spring]) if "/sqrt(" in name]
    assert len([name for name in lengths if re.match(r"a/sqrt\(.* \+ a\^2\)", name)]) == 3
    assert not any("/sqrt(" in name for name in varied_names(("mul", "sqrt"), [spring]))


def test_logarithms_are_of_distances_to_places_out_of_range():
    x = np.random.default_rng(0).uniform(-0.4, 0.6, (400, 1))
    found = varied([only(variable(0))], resolve(("mul", "log"), "test"), x)
    logs = [term for term in found if term.name(("q",)).startswith("log(")]
    assert len(logs) == 6  # three to each side
    for term in logs:
        assert np.isfinite(term.evaluate(x)).all()
    names = [term.name(("q",)) for term in varied([only(variable(0))], resolve(("mul",), "t"), x)]
    assert not any("log" in name for name in names)


def test_magnitudes_of_what_is_positive_are_nothing_but_itself():
    rows = np.random.default_rng(0).uniform([1.0, -1.0], [2.0, 1.0], (50, 2))
    size, speed = call(BUILTIN["abs"], variable(0)), call(BUILTIN["abs"], variable(1))
    term = only(call(BUILTIN["tanh"], mul(mul(size, variable(0)), speed)))
    (plain,) = without_signs(term, rows)
    assert plain.name(NAMES) == "tanh(q^2 abs(v))"


def test_constants_and_terms_of_time_are_not_varied():
    assert varied_names(("mul", "abs"), [ONE, only(mul(TIME, THRUST))]) == []
    assert varied_names(("abs", "sgn"), [only(THRUST)]) == []  # without products


def test_a_declared_term_is_no_variation_of_another():
    found = varied_names(("mul",), [only(variable(0)), only(mul(variable(0), THRUST))])
    assert "a T" not in found
    assert {"a^2", "a T^2", "a z"} <= set(found)
