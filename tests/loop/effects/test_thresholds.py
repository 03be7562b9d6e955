"""Stops on one side, valves and diodes begin beyond a threshold, and are found with it."""

import numpy as np
import pytest
from loop_systems import measured

import pysindy_evolve as pse
from pysindy_evolve.loop.effects.missing import candidates

OSCILLATOR = {"q": "v", "v": "-k*q - c*v + b*F"}


def offered(sides, low, high):
    """Return the thresholds of the last state, whose values go from low to high."""
    design = pse.DeclaredModel(sides, inputs=["F"]).design()
    n = len(design.states) + 2
    scales, middle = np.full(n, max(abs(low), abs(high))), np.full(n, 0.5 * (low + high))
    found = candidates(design, scales, np.full(n, low * high < 0.0), None, middle)
    return [c for c in found if c.name == "threshold"]


def test_thresholds_lie_within_the_range_and_begin_there():
    for low, high in ((-2.0, 1.0), (3.0, 5.0)):
        found = offered({"x": "b*F"}, low, high)
        assert len(found) == 16
        x = np.linspace(low, high, 500)
        for candidate in found:
            values = candidate.terms[0].evaluate(np.column_stack([x, x, x]))
            asleep = np.abs(values) < 1e-12
            assert 0.05 < asleep.mean() < 0.95
            assert np.abs(np.diff(values)[~asleep[1:]]) == pytest.approx(x[1] - x[0], rel=1.0)


def test_beside_a_spring_a_stop_is_offered_on_the_outer_side_only():
    free, sprung = (offered({"q": "v", "v": v}, -2.0, 2.0) for v in ("b*F", "b*F - k*q"))
    assert len(free) == 2 * len(sprung) == 16
    middle = np.zeros((1, 4))
    assert all(c.terms[0].evaluate(middle)[0] == pytest.approx(0.0) for c in sprung)


@pytest.mark.parametrize(
    ("stop", "place", "stiffness"),
    [
        ("- 100*(abs(q - 0.7) + q - 0.7)", 0.7, 200.0),
        ("- 30*(q + 0.5 - abs(q + 0.5))", -0.5, 60.0),
    ],
)
def test_a_stop_on_one_side_is_found_where_it_is(stop, place, stiffness):
    truth = {"q": "v", "v": f"-40*q - 0.8*v + F {stop}"}
    records = [measured(truth, seed=seed, noise=2e-3) for seed in range(2)]
    declared = pse.DeclaredModel(OSCILLATOR, inputs=["F"])
    report = pse.close_loop(declared, *records, random_state=0)
    (effect,) = report.effects
    assert effect.name == "threshold"
    assert effect.numbers["distance of the threshold from zero"] == pytest.approx(
        abs(place), rel=1e-3
    )
    assert effect.coefficients == pytest.approx([-stiffness], rel=1e-2)


def test_a_valve_that_opens_above_a_pressure_is_found():
    truth = {"p": "F + 30 - 3*p - 3*(abs(p - 12) + p - 12)"}
    records = [
        measured(truth, order=1, seed=s, noise=1e-2, x0=(10.0,), size=15.0) for s in range(2)
    ]
    declared = pse.DeclaredModel({"p": "b*F + o - k*p"}, inputs=["F"])
    report = pse.close_loop(declared, *records, operators=(), random_state=0)
    assert [effect.name for effect in report.effects] == ["threshold"]
    assert list(report.effects[0].numbers.values()) == pytest.approx([12.0], rel=1e-2)
