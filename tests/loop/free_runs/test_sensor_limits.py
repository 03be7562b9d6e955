"""A sensor that clips: it ruins no fit, is named as what it is, and hides nothing else."""

from dataclasses import replace

import numpy as np
import pytest
from loop_systems import DT, equations_of, multisine
from test_named_effects import DT as SLOW
from test_named_effects import FINE, TANK, found_in, inflow

import pysindy_evolve as pse
from pysindy_evolve.loop.evidence.findings import LimitFinding
from pysindy_evolve.loop.fitting.runs import simulation_errors
from pysindy_evolve.loop.free_runs.plateaus import plateaus
from pysindy_evolve.loop.free_runs.sensor_limits import clipped_sensors
from pysindy_evolve.loop.free_runs.state_limits import may_stop_itself
from pysindy_evolve.loop.free_runs.variants import Model
from pysindy_evolve.loop.given.declared import design_of
from pysindy_evolve.loop.given.limits import Limit
from pysindy_evolve.loop.given.rules import Rules

OSCILLATOR = pse.DeclaredModel({"q": "v", "v": "-k*q - c*v + b*F"}, inputs=["F"])
TRUTH = (40.0, 0.8, 1.0)


def clipped_oscillator(seed, ends=(0.0, 0.9), friction=0.0, duration=40.0):
    """An oscillator whose encoder shows no more than what lies between two of its quantiles."""
    force, t = multisine(20.0, seed), np.arange(0.0, duration, DT)
    sides = {"q": "v", "v": f"-40*q - 0.8*v + F - {friction}*sgn(v)"}
    q = pse.simulate(equations_of(sides, ("F",)), [0.0, 0.0], t, force, tolerance=1e-8)[:, 0]
    q = q + 2e-3 * q.std() * np.random.default_rng(seed + 1000).standard_normal(len(t))
    return pse.prepare(t, np.clip(q, *np.quantile(q, ends)), force(t))


def tank(seed, brim=np.inf, top=np.inf, n=900):
    """A tank that runs over at its brim, or whose sensor ends below it."""
    rng, fine = np.random.default_rng(seed), np.arange(n * FINE) * SLOW / FINE
    u, h, levels = inflow(fine, seed), 6.0, np.empty(n)
    for k, arriving in enumerate(u):
        if k % FINE == 0:
            levels[k // FINE] = h
        h = np.clip(h + SLOW / FINE * (0.02 * arriving - 0.024 * np.sqrt(h)), 0.0, brim)
    y = np.minimum(levels + 0.02 * rng.standard_normal(n), top)
    return pse.prepare(fine[::FINE], y, u[::FINE], order=1)


@pytest.mark.parametrize("ends", [(0.0, 0.9), (0.1, 1.0), (0.1, 0.9)])
def test_coefficients_owe_nothing_to_rows_that_the_sensor_did_not_see(ends):
    report = pse.close_loop(OSCILLATOR, clipped_oscillator(1, ends), max_effects=0, random_state=0)
    assert list(report.before.parameters.values()) == pytest.approx(TRUTH, rel=0.005)
    assert report.before.simulation_error.max() < 1.0


def test_a_run_behind_the_sensor_is_right_and_one_below_its_limit_is_not():
    record = clipped_oscillator(1, (0.0, 0.8))
    design = design_of(OSCILLATOR, [record])
    assert simulation_errors(design.equations(TRUTH), [record])[0] < 1.0
    weak = simulation_errors(design.equations((40.0, 0.8, 0.8)), [record])
    assert weak[0] > 10.0


def sensors_of(record, declared=OSCILLATOR):
    rules = Rules(significance=0.05, n_twins=59, min_share=0.05, max_effects=8)
    model = Model(design_of(declared, [record]))
    return clipped_sensors(model, [], [record], rules, np.random.default_rng(0))


def test_sensor_is_named_at_the_end_where_it_clips():
    for ends, uppers in (((0.0, 0.9), [True]), ((0.1, 1.0), [False]), ((0.1, 0.9), [True, False])):
        record = clipped_oscillator(2, ends)
        found = sensors_of(record)
        assert [f.limit.upper for f in found] == uppers
        assert all(f.p_value < 0.01 and f.limit.state == 0 for f in found)
        low, high = record.preparation.limits[:, 0]
        assert [f.limit.value for f in found] == [high if upper else low for upper in uppers]


def test_sensor_that_rounds_or_whose_range_is_never_reached_is_not_named():
    made = clipped_oscillator(2, (0.0, 1.0)).preparation
    assert sensors_of(pse.prepare(made.t, np.round(made.y, 2), made.u)) == []
    assert sensors_of(pse.prepare(made.t, made.y, made.u, limits=(-9.0, 9.0))) == []


def test_an_axis_that_sticks_at_its_highest_place_has_twins_that_do_so():
    sticking = equations_of({"q": "v", "v": "3*u - 2*v - 4*q - 6*sgn(v)"}, ("u",))
    t = np.arange(0.0, 20.0, 0.005)
    u = multisine(2.0, 5, (0.1, 1.0))(t)
    q = pse.simulate(sticking, [0.0, 0.0], t, u)[:, 0]
    record = pse.prepare(t, 1e-4 * np.round(q / 1e-4), u)
    there = Limit(0, float(record.preparation.y.max()), 200.0, upper=True)
    observed, in_twins = plateaus(there, sticking, [record], 19, np.random.default_rng(0))
    assert observed > 10
    assert in_twins == pytest.approx(observed, abs=0.1 * observed)


@pytest.mark.parametrize("seed", [2, 3, 5])
def test_runs_tell_a_tank_that_runs_over_from_a_sensor_that_ends(seed):
    rules, records = Rules(0.05, 59, 0.05, 8), [tank(seed, brim=8.0, top=8.0), tank(seed, top=8.0)]
    design, rng = design_of(TANK, records), np.random.default_rng(0)
    assert [may_stop_itself(design, [record], rules, rng) for record in records] == [True, False]
    (sensor,) = sensors_of(records[1], TANK)
    assert sensor.limit.value == 8.0


@pytest.mark.slow
@pytest.mark.parametrize("seed", [2, 5])
def test_tank_that_runs_over_is_found_to_stop_there(seed):
    record = tank(seed, brim=8.0, top=8.0)
    (over,) = found_in(replace(record, seen=None))
    assert isinstance(over, LimitFinding)
    assert over.limit.value == 8.0


@pytest.mark.slow
def test_friction_is_found_beside_a_sensor_that_clips():
    record = clipped_oscillator(3, (0.06, 0.94), friction=1.0, duration=60.0)
    report = pse.close_loop(OSCILLATOR, record, operators=(), random_state=0)
    names = [(effect.name, effect.place) for effect in report.effects]
    sensor = ("saturation", "the sensor of q")
    assert names == [("Coulomb friction", "the equation of v"), sensor, sensor]
    assert list(report.after.parameters.values()) == pytest.approx(TRUTH, rel=0.01)
    assert report.after.simulation_error.max() < 1.0
    low, high = record.preparation.limits[:, 0]
    run = report.simulate(report.test[0])[:, 0]
    assert (run.min(), run.max()) == (low, high)
    for text in (str(report), report.to_markdown()):
        assert f"The sensor of q shows min(q, {high:.4g})" in text
        assert f"The sensor of q shows max(q, {low:.4g})" in text
        assert "saturation in the sensor of q" in text


@pytest.mark.slow
def test_tank_behind_a_sensor_that_ends_keeps_its_coefficients():
    report = pse.close_loop(TANK, tank(2, top=8.0), operators=(), random_state=0)
    assert [effect.place for effect in report.effects] == ["the sensor of h"]
    assert list(report.after.parameters.values()) == pytest.approx((0.02, 0.024), rel=0.01)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 2])
def test_nothing_but_the_sensor_is_named_where_nothing_else_is_missing(seed):
    report = pse.close_loop(OSCILLATOR, clipped_oscillator(seed + 10), random_state=0)
    assert [effect.place for effect in report.effects] == ["the sensor of q"]
    assert report.verdict == "traced"
