"""Names of frictions and dampings: of velocities as they are, of other states in neutral words."""

from dataclasses import replace

import numpy as np
import pytest

import pysindy_evolve as pse
from pysindy_evolve.loop.report.effect_text import evidence
from pysindy_evolve.loop.report.printed_names import PARAMETRIC, as_printed
from pysindy_evolve.operators import BUILTIN
from pysindy_evolve.terms import call, constant, mul, variable

FIRST_ORDER = {"q": "-k*q", "v": "-c*v + b*F"}


def declared(sides, **options):
    return pse.DeclaredModel(sides, inputs=["F"], **options).design()


def of_levels(outcome):
    """Return the outcome as if q and v were levels, which stay above zero and are no motion."""
    train = [replace(record, x=1.0 + np.abs(record.x)) for record in outcome.train]
    return replace(outcome, design=declared(FIRST_ORDER), train=train)


def test_the_speed_of_a_motor_has_friction_though_no_equation_has_its_angle(report):
    printed = as_printed(replace(report, design=declared(FIRST_ORDER)))
    assert [one.name for one in printed.effects] == [one.name for one in report.effects]


def test_friction_of_a_velocity_keeps_its_name(report):
    printed = as_printed(report)
    assert [one.name for one in printed.effects] == [one.name for one in report.effects]
    assert [one.name for one in printed.steps] == [one.name for one in report.steps]


def test_friction_of_a_state_that_is_no_velocity_is_a_sign_term(report):
    printed = as_printed(of_levels(report))
    assert [one.name for one in printed.effects] == ["constant offset", "sign term"]
    assert "sign term" in [one.name for one in printed.steps]
    assert report.effects[-1].name == "Coulomb friction"  # the name in the API
    lines = evidence(printed.effects[-1], report.equations.inner_symbols)
    assert "if v is a velocity, it is Coulomb friction" in lines


def test_effects_of_one_step_still_share_their_errors(report):
    printed = as_printed(of_levels(report))
    assert [s.errors for s in printed.steps] == [s.errors for s in report.steps]


def test_best_that_did_not_pass_has_the_printed_name_too(complete):
    best = complete.rejected
    drag = replace(best.tried.group[0], name="quadratic drag", state=1)
    tried = replace(best, tried=replace(best.tried, group=(drag,)))
    outcome = replace(complete, rejected=tried)
    assert as_printed(outcome).rejected.name == "quadratic drag"
    assert as_printed(of_levels(outcome)).rejected.name == ("quadratic term")


@pytest.mark.parametrize(("variable_", "name"), [(1, "threshold"), (2, "dead zone")])
def test_dead_zone_of_a_level_is_a_threshold_and_of_an_input_a_dead_zone(report, variable_, name):
    zone = replace(report.effects[-1], name="dead zone", expressions=(variable(variable_),))
    outcome = of_levels(replace(report, effects=[zone]))
    assert as_printed(outcome).effects[0].name == name


def test_a_forcing_that_multiplies_a_term_is_a_parametric_excitation(report):
    time = report.design.time
    wave = call(BUILTIN["sin"], variable(time))
    for factor, name in ((constant(1.0), "periodic forcing"), (variable(0), PARAMETRIC)):
        pumped = replace(
            report.effects[-1], name="periodic forcing", expressions=(mul(factor, wave),)
        )
        assert as_printed(replace(report, effects=[pumped])).effects[0].name == name


def test_a_force_has_the_frictions_of_its_velocities(report):
    force = declared({"q": "k*F", "v": "c*F"}, algebraic=True)
    printed = as_printed(replace(report, design=force))
    assert [one.name for one in printed.effects] == [one.name for one in report.effects]


@pytest.mark.parametrize(("sign", "is_said"), [(1.0, False), (-1.0, True)])
def test_a_friction_that_drives_is_said_to_do_so(report, sign, is_said):
    effect = report.effects[-1]
    ends = np.sort(sign * effect.confidence_intervals, axis=1)
    turned = replace(effect, coefficients=sign * effect.coefficients, confidence_intervals=ends)
    printed = as_printed(of_levels(replace(report, effects=[turned])))
    lines = evidence(printed.effects[0], report.equations.inner_symbols)
    assert ("if v is a velocity, it is negative Coulomb friction" in lines) is is_said
    lines = evidence(turned, report.equations.inner_symbols)
    assert (
        "its sign is positive: it drives the motion instead of resisting it" in lines
    ) is is_said
