"""Friction of unequal directions is an offset and a friction."""

import pytest
from loop_systems import measured

import pysindy_evolve as pse


@pytest.fixture(scope="module")
def report():
    truth = {"q": "v", "v": "-40*q - 0.8*v + F - 2*sgn(v) + 1.2"}
    model = pse.DeclaredModel({"q": "v", "v": "-k*q - c*v + b*F"}, inputs=["F"])
    return pse.close_loop(model, measured(truth), operators=(), random_state=0, n_twins=59)


def test_offset_and_friction_together_have_their_other_name(report):
    assert {e.name for e in report.effects} == {"constant offset", "Coulomb friction"}
    for effect in report.effects:
        assert effect.alternatives == ("asymmetric Coulomb friction",)
    name = "together with another effect here it is also called asymmetric Coulomb friction"
    assert name in str(report)


def test_no_experiment_is_proposed_for_two_names_of_one_force(report):
    assert str(report.suggest_experiment()).startswith("Nothing to tell apart")


def test_friction_alone_has_no_other_name():
    truth = {"q": "v", "v": "-40*q - 0.8*v + F - 2*sgn(v)"}
    model = pse.DeclaredModel({"q": "v", "v": "-k*q - c*v + b*F"}, inputs=["F"])
    report = pse.close_loop(
        model, measured(truth, duration=20.0), operators=(), random_state=0, n_twins=59
    )
    assert [(e.name, e.alternatives) for e in report.effects] == [("Coulomb friction", ())]
