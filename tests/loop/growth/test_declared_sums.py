"""A declared sum times a function of a variable is found as a whole, with the function's number."""

import numpy as np
import pytest
from loop_systems import equations_of

import pysindy_evolve as pse
from pysindy_evolve.loop.effects.names import EVOLVED
from pysindy_evolve.loop.given.declared import design_of
from pysindy_evolve.loop.given.segments import segments
from pysindy_evolve.loop.growth.declared_sums import terms_with_sums
from pysindy_evolve.loop.growth.genetic_search import OPERATORS
from pysindy_evolve.operators import resolve

COOLED = pse.DeclaredModel({"T": "b*P - h*(T - A)"}, inputs=["P", "n", "A"])


def cooled(exponent):
    """Record a heated fin in a breeze: its loss grows with a power of the speed of a fan."""
    return cooled_by(f"exp({exponent}*log(n))")


def cooled_by(factor):
    """Record a heated fin in a breeze, whose loss grows with a function of the speed of a fan."""
    t, rng = np.arange(0.0, 4000.0, 4.0), np.random.default_rng(0)
    heater, fan = (
        np.convolve(np.repeat(rng.uniform(*ends, 40), 26), np.ones(5) / 5.0, "same")[20:-20]
        for ends in ((5.0, 40.0), (5.0, 60.0))
    )
    inputs = np.column_stack([heater, fan, 22.0 + 3.0 * np.sin(0.003 * t)])
    truth = {"T": f"0.08*P - (0.004 + 0.0012*{factor})*(T - A)"}
    x = pse.simulate(equations_of(truth, ("P", "n", "A")), [50.0], t, inputs)
    y = x + 1e-3 * x.std() * rng.standard_normal(x.shape)
    return pse.prepare(t, y, inputs, order=1)


def best(record, operators):
    design, part = design_of(COOLED, [record]), segments([record])
    variables = np.column_stack([record.x, record.u])
    return terms_with_sums(design, 0, part, resolve(operators, "test"), variables)


@pytest.mark.parametrize("exponent", [0.5, 0.8])
def test_the_loss_to_the_surroundings_grows_with_a_power_of_a_fan(exponent):
    record = cooled(exponent)
    found = best(record, OPERATORS)
    (term,) = found[0].terms
    rows = np.column_stack([record.x, record.u, record.t])
    whole = term.evaluate(rows) / (rows[:, 0] - rows[:, 3])
    slopes = np.diff(np.log(np.abs(whole))) / np.diff(np.log(rows[:, 2]))
    assert np.median(slopes) == pytest.approx(exponent, rel=0.03)
    assert (found[0].name, found[0].state) == (EVOLVED, 0)
    assert found[0].size < 12  # the sum counts as one node


def test_a_form_far_from_its_numbers_on_the_grid_is_tuned_before_it_is_compared():
    """A Hill function of the fourth order was dropped for worse forms that began closer."""
    record = cooled_by("10*n^4/(30^4 + n^4)")
    found = best(record, OPERATORS)
    rows = np.column_stack([record.x, record.u, record.t])
    fan, whole = rows[:, 2], found[0].terms[0].evaluate(rows) / (rows[:, 0] - rows[:, 3])
    assert np.corrcoef(whole, fan**4 / (30.0**4 + fan**4))[0, 1] ** 2 > 0.9999
    assert len({one.form for one in found}) == len(found)


@pytest.mark.parametrize("beside", ["", " + 3"])
def test_a_function_of_a_sum_comes_with_an_offset_only_if_that_is_needed(beside):
    """A force |x - y|^1.5 was refused for want of the offset beside it."""
    t, rng = np.arange(0.0, 60.0, 0.02), np.random.default_rng(0)
    push = np.convolve(np.repeat(rng.uniform(-6.0, 6.0, 63), 50), np.ones(20) / 20.0, "same")[:3000]
    truth = {"x": f"F - x - 0.4*(x - y) - 0.2*exp(1.5*log(abs(x - y))){beside}", "y": "x - 2*y"}
    x = pse.simulate(equations_of(truth, ("F",)), [0.5, 0.1], t, push)
    record = pse.prepare(t, x + 1e-3 * rng.standard_normal(x.shape), push, order=1)
    declared = pse.DeclaredModel({"x": "b*F - a*x - k*(x - y)", "y": "c*x - d*y"}, inputs=["F"])
    design = design_of(declared, [record])
    variables = np.column_stack([record.x, record.u])
    operators = resolve(OPERATORS, "test")
    found = terms_with_sums(design, 0, segments([record]), operators, variables)
    assert len(found[0].terms) == (2 if beside else 1)
    assert found[0].shape.values == pytest.approx((1.5,), rel=0.05)


def test_there_are_none_without_products_or_declared_sums():
    record = cooled(0.5)
    assert best(record, ("sin", "exp")) == []
    single = pse.DeclaredModel({"T": "b*P - h*T"}, inputs=["P", "n", "A"])
    variables = np.column_stack([record.x, record.u])
    operators = resolve(OPERATORS, "test")
    design = design_of(single, [record])
    assert terms_with_sums(design, 0, segments([record]), operators, variables) == []


@pytest.mark.slow
def test_the_fan_is_found_though_it_acts_nowhere_in_the_declared_model():
    report = pse.close_loop(COOLED, cooled(0.8), n_twins=59, random_state=0)
    assert len(report.effects) == 1
    assert report.verdict == "traced"
    assert report.after.simulation_error[0] < 0.01 * report.before.simulation_error[0]
