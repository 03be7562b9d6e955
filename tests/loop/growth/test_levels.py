"""What begins at a level of a first-order state is held against what grows."""

import numpy as np
import pytest
from loop_systems import equations_of, multisine

import pysindy_evolve as pse
from pysindy_evolve.loop.given.declared import design_of
from pysindy_evolve.loop.given.segments import segments
from pysindy_evolve.loop.growth.levels import terms_from_levels

TANK = pse.DeclaredModel({"h": "b*u - a*sqrt(h)"}, inputs=["u"])
RIG = pse.DeclaredModel({"q": "v", "v": "b*u - k*q"}, inputs=["u"])


def tank(seed: int, loss: str = "- 0.06*max(h - 8, 0)") -> pse.Record:
    """A tank that runs over at a level of 8, or loses something else."""
    t = np.arange(0.0, 2000.0, 2.0)
    u = 0.8 + multisine(0.3, seed, (5e-4, 8e-3))(t)
    truth = equations_of({"h": f"0.35*u - 0.1*sqrt(h) {loss}"}, ("u",))
    h = pse.simulate(truth, [4.0], t, u)
    noise = 0.003 * np.random.default_rng(seed).standard_normal(h.shape)
    return pse.prepare(t, h + noise, u, order=1)


def test_the_level_is_tuned_and_needs_no_offset_beside_it():
    record = tank(1)
    found = terms_from_levels(design_of(TANK, [record]), 0, segments([record]))
    assert found
    assert all(candidate.parents == () for candidate in found)
    assert min(abs(c.shape.values[0] - 8.0) for c in found) < 0.1


def test_a_velocity_has_none_for_its_position_has_stops():
    t = np.arange(0.0, 20.0, 0.02)
    record = pse.prepare(t, np.cos(t), multisine(1.0, 1)(t))
    assert terms_from_levels(design_of(RIG, [record]), 1, segments([record])) == []


@pytest.mark.slow
def test_an_overflow_is_named_where_it_begins():
    report = pse.close_loop(TANK, tank(2), n_twins=59, random_state=0)
    (effect,) = report.effects
    assert effect.name == "dead zone"
    assert effect.numbers["end"] == pytest.approx(8.0, rel=0.01)
    assert effect.coefficients == pytest.approx([-0.06], rel=0.03)
    assert report.after.parameters == pytest.approx({"b": 0.35, "a": 0.1}, rel=0.01)


@pytest.mark.slow
def test_a_hole_in_the_wall_is_a_root_of_the_head_above_it():
    report = pse.close_loop(TANK, tank(3, "- 0.2*sqrt(max(h - 6, 0))"), n_twins=59, random_state=0)
    (effect,) = report.effects
    assert effect.numbers["inner constant"] == pytest.approx(6.0, rel=0.01)
    assert effect.coefficients == pytest.approx([-0.2], rel=0.03)
    assert "sqrt(max(h - " in str(report)
