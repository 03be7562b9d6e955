"""Small terms come in along short records, where no search could be tested."""

import numpy as np
import pytest

import pysindy_evolve as pse

REPLICATION = {"a": "a*b - 1.61*a**2*b", "b": "a*b - 1.61*a*b**2"}
STARTS = ((0.3, 0.04), (0.1, 0.21), (0.22, 0.11))


def records_of(rates, starts, noise=5e-3, seed=0):
    """Ten seconds of a slow change, which hold hardly a cycle."""
    model, t = pse.DeclaredModel(rates).design().equations([]), np.linspace(0.0, 10.0, 1000)
    rng, records = np.random.default_rng(seed), []
    for start in starts:
        x = pse.simulate(model, list(start), t, tolerance=1e-9)
        y = x + noise * x.std(axis=0) * rng.standard_normal(x.shape)
        records.append(pse.prepare(t, y, order=1))
    return records


@pytest.fixture(scope="module")
def replication():
    return records_of(REPLICATION, STARTS)


@pytest.mark.slow
def test_a_product_of_three_states_is_found_on_slow_records(replication):
    declared = pse.DeclaredModel({"a": "p*a*b", "b": "r*a*b - s*a*b**2"})
    report = pse.close_loop(declared, replication[:2], replication[2:], random_state=0)
    assert report.rules.by_trajectory
    (effect,) = report.effects
    named = (effect.name, effect.state, str(effect.term))
    assert named == ("coupling", "a", "a**2*b")
    assert effect.coefficients == pytest.approx([-1.61], rel=0.01)
    assert np.all(report.after.simulation_error < 0.2)


def test_nothing_grows_where_nothing_is_missing(replication):
    declared = pse.DeclaredModel({"a": "p*a*b - q*a**2*b", "b": "r*a*b - s*a*b**2"})
    report = pse.close_loop(declared, replication[:2], replication[2:], random_state=0)
    assert report.verdict == "complete"


@pytest.mark.slow
def test_nothing_grows_without_operators(replication):
    declared = pse.DeclaredModel({"a": "p*a*b", "b": "r*a*b - s*a*b**2"})
    report = pse.close_loop(
        declared, replication[:2], replication[2:], operators=(), random_state=0
    )
    assert "evolved term" not in {effect.name for effect in report.effects}


def test_names_keep_their_place_where_a_term_does_as_well():
    records = records_of({"x": "2 - 0.3*x"}, ((0.0,), (12.0,)), noise=0.01)
    declared = pse.DeclaredModel({"x": "g"})
    report = pse.close_loop(declared, records[0], records[1], random_state=0)
    assert report.rules.by_trajectory
    assert [effect.name for effect in report.effects] == ["viscous damping"]


@pytest.mark.slow
def test_one_term_takes_the_place_of_two_names_that_do_worse():
    records = records_of({"x": "0.3 - 1.5*tanh(2*x)"}, ((3.0,), (-3.5,), (2.0,)))
    declared = pse.DeclaredModel({"x": "g"})
    report = pse.close_loop(declared, records[:2], records[2:], random_state=0)
    (effect,) = report.effects
    assert effect.name == "evolved term"
    assert report.after.simulation_error[0] < 1.0
