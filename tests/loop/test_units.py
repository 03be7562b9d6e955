"""Units are the user's: densities per cubic centimeter are treated as numbers about one are."""

import numpy as np
import pytest

import pysindy_evolve as pse

NOISE = 2e-3


def decays(unit, drag):
    """Records of x' = -x / 2 - drag x^2, in closed form, with noise and in another unit of x."""
    t, rng = np.arange(0.0, 8.0, 0.02), np.random.default_rng(0)
    curves = (1.0 / ((1.0 / x0 + 2 * drag) * np.exp(t / 2) - 2 * drag) for x0 in (2.0, 1.2, 1.6))
    noisy = [x + NOISE * rng.standard_normal(len(t)) for x in curves]
    return [pse.prepare(t, unit * x, order=1) for x in noisy]


def found(unit, drag, side="-a*x"):
    train, declared = decays(unit, drag), pse.DeclaredModel({"x": side})
    report = pse.close_loop(declared, train[:2], test=train[2], operators=(), random_state=0)
    return report.verdict, [effect.name for effect in report.effects]


@pytest.mark.parametrize("unit", [1.0, 1e27, 1e-27])
@pytest.mark.parametrize("drag", [0.0, 0.2])
def test_what_is_found_does_not_depend_on_the_unit_of_a_state(unit, drag):
    expected = ("traced", ["quadratic drag"]) if drag else ("complete", [])
    assert found(unit, drag) == expected


@pytest.mark.parametrize("unit", [1e18, 1e-18, 1e27, 1e-27])
def test_a_declared_cube_of_a_state_may_have_any_unit(unit):
    verdict, effects = found(unit, 0.2, "-a*x - b*x**2 - c*x**3")
    assert (verdict, effects) == ("complete", [])
