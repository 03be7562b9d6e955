"""Declared numbers that differ between records are said, each with what it is there."""

from dataclasses import replace

import numpy as np
import pytest
from loop_systems import measured

import pysindy_evolve as pse
from pysindy_evolve.loop.facts.record_differences import numbers_by_record

# What is looked at is what the records say of the model, and not how well it does on others.
pytestmark = pytest.mark.filterwarnings("ignore:.*samples of a test record")

MODEL = pse.DeclaredModel({"q": "v", "v": "-k*q - c*v - f*sgn(v) + b*F"}, inputs=["F"])


def report_of(*frictions):
    records = [
        measured({"q": "v", "v": f"-40*q - 0.8*v - {friction}*sgn(v) + F"}, seed=seed)
        for seed, friction in enumerate(frictions)
    ]
    return pse.close_loop(MODEL, records, records[0], operators=(), max_effects=0)


def said_of(*frictions):
    return " ".join(str(report_of(*frictions)).split())


def test_a_friction_that_differs_is_named_alone_with_its_values():
    said = said_of(2.4, 1.6)
    assert said.count("Fitted to each training record by itself") == 1
    values = said.partition("by itself, f is ")[2].partition(".  ")[0].split()[:2]
    assert [float(one.strip(",.")) for one in values] == pytest.approx([2.4, 1.6], rel=0.05)


def test_numbers_that_records_share_are_not_said_to_differ():
    assert "by itself" not in said_of(2.0, 2.0)


def test_a_number_that_differs_by_no_more_than_its_interval_is_not_named():
    report = report_of(2.4, 1.6)
    assert list(numbers_by_record(report)) == ["f"]
    unsure = replace(report.after, parameter_intervals={"f": np.array([1.7, 2.3])})
    assert numbers_by_record(replace(report, after=unsure)) == {}


@pytest.mark.parametrize(("stiffness", "named"), [(40.2, []), (41.0, ["k"])])
def test_a_number_that_differs_by_less_than_a_hundredth_is_not_named(stiffness, named):
    records = [
        measured({"q": "v", "v": f"-{k}*q - 0.8*v - 2*sgn(v) + F"}, seed=seed, noise=1e-5)
        for seed, k in enumerate((40.0, stiffness))
    ]
    report = pse.close_loop(MODEL, records, records[0], operators=(), max_effects=0)
    assert list(numbers_by_record(report)) == named


@pytest.mark.slow
def test_a_mass_that_differs_is_said_beside_the_effect_that_was_found():
    records = [
        measured({"q": "v", "v": f"(-40*q - 0.8*v - 2*sgn(v) + F)/{mass}"}, seed=seed)
        for seed, mass in enumerate((1.0, 1.3))
    ]
    declared = pse.DeclaredModel({"q": "v", "v": "-k*q - c*v + b*F"}, inputs=["F"])
    report = pse.close_loop(declared, records, records[0], operators=(), n_twins=59, random_state=0)
    assert [effect.name for effect in report.effects] == ["Coulomb friction"]
    assert numbers_by_record(report)["b"] == pytest.approx([1.0, 1.0 / 1.3], rel=0.02)
    assert str(report).count("by itself, ") == 1


def test_an_effect_of_one_word_is_no_declared_number():
    report = report_of(2.4, 1.6)
    named = [
        replace(c, name={"f": "hysteresis"}.get(c.name, c.name)) for c in report.design.columns
    ]
    design = replace(report.design, columns=tuple(named))
    assert numbers_by_record(replace(report, design=design)) == {}
