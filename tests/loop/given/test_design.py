"""Design: known parts plus columns times coefficients."""

import numpy as np
import pytest

from pysindy_evolve import DeclaredModel
from pysindy_evolve.loop.given.design import in_state
from pysindy_evolve.operators import BUILTIN
from pysindy_evolve.terms import call, variable


def two_masses():
    return DeclaredModel(
        {"a": "va", "va": "-k*(a - b) + F", "b": "vb", "vb": "-k*(b - a) - c*vb"}, inputs=["F"]
    ).design()


def test_equations_are_known_parts_plus_columns_times_coefficients():
    design = two_masses()
    z = np.random.default_rng(0).normal(size=(20, 6))
    x_dot = design.equations([3.0, 0.7]).evaluate(z[:, :4], z[:, 4:5], z[:, 5])
    a, va, b, vb, force, _ = z.T
    expected = np.column_stack([va, -3 * (a - b) + force, vb, -3 * (b - a) - 0.7 * vb])
    assert x_dot == pytest.approx(expected)
    columns = sum(
        c * column.evaluate(z) for c, column in zip([3.0, 0.7], design.columns, strict=True)
    )
    assert design.known(z) + columns == pytest.approx(expected)


def test_column_that_repeats_a_known_term_adds_to_it():
    design = DeclaredModel({"v": "-2*v - c*v"}).design()
    equations = design.equations([0.5])
    assert len(equations.terms) == 1
    assert equations.coef == pytest.approx(np.array([[-2.5]]))


def test_equations_without_free_parameters_or_terms_are_zero():
    design = DeclaredModel({"q": "0", "v": "0"}).design()
    assert (
        design.equations([]).evaluate(np.ones((3, 2)), None, np.zeros(3)).tolist() == [[0, 0]] * 3
    )


def test_wrong_number_of_coefficients_is_not_taken():
    with pytest.raises(ValueError, match=r"longer|shorter"):
        two_masses().equations([1.0])


def test_kinematic_equations_are_those_that_only_name_another_state():
    design = two_masses()
    assert [design.kinematic(state) for state in range(4)] == [True, False, True, False]
    assert design.open_states == (1, 3)


@pytest.mark.parametrize("text", ["2*v", "v + 1", "-v", "v^2", "c*v", "q", "F", "v + c*q"])
def test_other_equations_are_open(text):
    design = DeclaredModel({"q": text, "v": "-k*q"}, inputs=["F"]).design()
    assert not design.kinematic(0)
    assert design.open_states == (0, 1)


def test_position_and_derivative_find_each_other():
    design = two_masses()
    assert [design.position_of(state) for state in range(4)] == [None, 0, None, 2]
    assert [design.derivative_of(state) for state in range(4)] == [1, None, 3, None]


def test_column_added_to_a_kinematic_equation_opens_it():
    design = two_masses()
    opened = design.adding([in_state("offset", variable(1), 0, 4)])
    assert opened.open_states == (0, 1, 3)


def test_adding_appends_and_dropping_undoes_it():
    design = two_masses()
    friction = in_state("Coulomb friction", call(BUILTIN["sgn"], variable(1)), 1, 4)
    richer = design.adding([friction])
    assert [column.name for column in richer.columns] == ["k", "c", "Coulomb friction"]
    assert richer.dropping([friction]) == design
    z = np.array([[0.0, -3.0, 0.0, 0.0, 0.0, 0.0]])
    assert friction.evaluate(z) == pytest.approx(np.array([[0.0, -1.0, 0.0, 0.0]]))
