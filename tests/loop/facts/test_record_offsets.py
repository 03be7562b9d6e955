"""Offsets that differ between records are no fixed term, and the model is not complete."""

import pytest
from loop_systems import measured

import pysindy_evolve as pse

MODEL = pse.DeclaredModel({"q": "v", "v": "-k*q - c*v + b*F"}, inputs=["F"])


def report_of(offsets):
    sides = ({"q": "v", "v": f"-40*q - 0.8*v + F + {load}"} for load in offsets)
    records = [measured(side, noise=5e-3, seed=k, duration=20.0) for k, side in enumerate(sides)]
    return pse.close_loop(
        MODEL, records[:-1], test=records[-1], operators=(), random_state=0, n_twins=59
    )


@pytest.mark.slow
def test_a_load_that_differs_between_records_is_not_complete():
    report = report_of((2.0, -3.0, 0.5))
    assert report.verdict == "untraced"
    assert not report.effects
    assert "has a different mean in each training record" in " ".join(str(report).split())


@pytest.mark.slow
def test_a_load_that_is_the_same_is_an_offset():
    report = report_of((2.0, 2.0, 2.0))
    assert [effect.name for effect in report.effects] == ["constant offset"]
    assert "different mean" not in str(report)


@pytest.mark.slow
def test_records_that_lack_nothing_have_one_mean():
    assert report_of((0.0, 0.0, 0.0)).verdict == "complete"
