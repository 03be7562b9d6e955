"""Frictions that fall with the speed."""

import numpy as np
import pytest
from loop_systems import measured

import pysindy_evolve as pse
from pysindy_evolve.loop.effects.candidate import CandidateMaker
from pysindy_evolve.loop.effects.frictions import frictions, tustin_form
from pysindy_evolve.loop.effects.missing import candidates
from pysindy_evolve.loop.given.ranges import Ranges
from pysindy_evolve.terms import variable


def test_stribeck_friction_alone_may_fall_with_the_speed_itself():
    v = np.linspace(-2.0, 2.0, 41)
    for friction in frictions(CandidateMaker(1), variable(1), 2.0):
        form = tustin_form(friction)
        assert (form is not None) == (friction.name == "Stribeck friction")
        if form is not None:
            (speed,) = form.shape.values
            (values,) = (term.evaluate(np.column_stack([v, v])) for term in form.terms)
            assert values == pytest.approx(np.sign(v) * np.exp(-np.abs(v) / speed))
            assert (form.name, form.parents) == (friction.name, friction.parents)


@pytest.mark.slow
@pytest.mark.parametrize("exponent", ["v^2/0.09", "abs(v)/0.3"])
def test_how_friction_falls_with_the_speed_is_told_by_free_runs(exponent):
    truth = {"q": "v", "v": f"F - 20*q - 0.8*v - sgn(v) - 1.5*exp(-{exponent})*sgn(v)"}
    record = measured(truth, size=6.0, noise=1e-4)
    declared = pse.DeclaredModel({"q": "v", "v": "b*F - k*q - c*v - f*sgn(v)"}, inputs=["F"])
    report = pse.close_loop(declared, record, operators=(), n_twins=59, random_state=0)
    (effect,) = report.effects
    assert effect.name == "Stribeck friction"
    assert str(effect.term).count("Abs") == exponent.count("abs")
    assert effect.coefficients == pytest.approx([-1.5], rel=0.03)


def test_the_factor_by_which_a_friction_enters_stays_where_its_exponent_changes():
    declared = pse.DeclaredModel({"q": "v", "v": "(b*F - c*v)/(1 + 0.25*sin(q)**2)"}, inputs=["F"])
    rows = np.random.default_rng(0).normal(size=(300, 4))
    offered = candidates(declared.design(), Ranges.of(rows))
    entering = [c for c in offered if c.name == "Stribeck friction" and 0 in c.variables]
    assert entering
    for friction in entering:
        form = tustin_form(friction)
        (speed,) = form.shape.values
        factor = 1.0 / (4.0 + np.sin(rows[:, 0]) ** 2)
        v = rows[:, 1]
        expected = factor * np.sign(v) * np.exp(-np.abs(v) / speed)
        values = form.terms[0].evaluate(rows)
        assert values / values[0] == pytest.approx(expected / expected[0])
        assert (form.parents, form.acts_at[0]) == (friction.parents, friction.acts_at[0])
        assert tustin_form(form) is None
