"""What a term is worth may go up and down with the position: torque ripple, a worn guide."""

import numpy as np
import pytest
from loop_systems import measured

import pysindy_evolve as pse
from pysindy_evolve.loop.effects.modulation import ActingTerm, rippling
from pysindy_evolve.loop.effects.rippled_terms import rippled_candidates
from pysindy_evolve.terms import constant, variable

RNG = np.random.default_rng(0)
PLACE = np.cumsum(0.02 * RNG.standard_normal(4000))  # wanders back and forth
FORCE = RNG.standard_normal(4000)
MOTOR = {"q": "v", "v": "-1.5*v + 1.3*F"}


def test_a_ripple_is_found_over_places_that_are_passed_unevenly():
    residual = FORCE * (0.3 + 0.2 * np.sin(30.0 * PLACE + 1.0)) + 0.05 * RNG.standard_normal(4000)
    (found,) = rippling(residual - 0.3 * FORCE, FORCE, PLACE, 500, 4)
    assert 2.0 * np.pi * found == pytest.approx(30.0, rel=0.01)


@pytest.mark.parametrize("values", [FORCE, np.full(4000, np.nan)])
def test_noise_does_not_ripple(values):
    assert rippling(RNG.standard_normal(4000), values, PLACE, 500, 4) == []


@pytest.mark.parametrize(
    ("part", "name"),
    [(variable(2), "position-periodic ripple"), (variable(1), "position-dependent friction")],
)
def test_what_ripples_is_called_by_what_it_depends_on(part, name):
    residual = FORCE * np.cos(30.0 * PLACE)
    (one,) = rippled_candidates(1, 0, residual, ActingTerm(part, FORCE), PLACE)
    assert (one.name, one.state, one.parents) == (name, 1, (part,))
    assert len(one.terms) == 2
    assert one.shape.named["wave number"] == pytest.approx(30.0, rel=0.02)


def test_a_spring_does_not_ripple_nor_does_what_stands_still_or_is_finer_than_the_sensor():
    residual = FORCE * np.cos(30.0 * PLACE)
    spring, force = ActingTerm(variable(0), FORCE), ActingTerm(variable(2), FORCE)
    assert rippled_candidates(1, 0, residual, spring, PLACE) == []
    assert rippled_candidates(1, 0, residual, force, 0.0 * PLACE) == []
    assert rippled_candidates(1, 0, residual, force, PLACE, 0.1) == []
    short = ActingTerm(constant(1.0), FORCE[:9])
    assert rippled_candidates(1, 0, residual[:9], short, PLACE[:9]) == []


@pytest.mark.slow
@pytest.mark.parametrize("share", [0.05, 0.15])
def test_the_torque_of_a_motor_that_goes_up_and_down_from_pole_to_pole(share):
    model = pse.DeclaredModel({"q": "v", "v": "-c*v + k*F"}, inputs=["F"])
    truth = MOTOR | {"v": f"-1.5*v + 1.3*F*(1 + {share}*sin(4*q + 0.7))"}
    records = [measured(truth, noise=2e-4, seed=seed) for seed in (3, 4)]
    report = pse.close_loop(model, *records, operators=(), random_state=0)
    (effect,) = report.effects
    assert effect.name == "position-periodic ripple"
    assert effect.numbers["wave number"] == pytest.approx(4.0, rel=2e-3)
    assert np.hypot(*effect.coefficients) == pytest.approx(1.3 * share, rel=0.05)
