"""Inputs that turn out to be held when all else was found."""

import numpy as np
import pytest
from loop_systems import regulated

import pysindy_evolve as pse
from pysindy_evolve.loop.effects.candidate import OFFSET, Candidate
from pysindy_evolve.loop.evidence.findings import Finding
from pysindy_evolve.loop.evidence.scoring import columns_of
from pysindy_evolve.loop.given.rules import Rules
from pysindy_evolve.loop.given.segments import segments
from pysindy_evolve.loop.memories.hold_or_memory import hold_replaces
from pysindy_evolve.loop.search.found import Found
from pysindy_evolve.loop.search.how_inputs_act import with_holds
from pysindy_evolve.operators import BUILTIN
from pysindy_evolve.terms import call, mul, variable


@pytest.mark.parametrize("is_held", [True, False])
def test_a_hold_that_no_effect_was_found_beside_is_taken(is_held):
    """Damping is missing: without it the hold does worse, and without the hold it does."""
    record = regulated(is_held, 8)
    design = pse.DeclaredModel({"q": "v", "v": "b*M"}, inputs=["M"]).design()
    taken = with_holds(Found(design, [record], segments([record]), Rules(0.05, 59, 0.05, 4), ()))
    assert (taken is not None) == is_held
    if taken is not None:
        assert taken.held == {0: 0.5}


RULES = Rules(0.05, 59, 0.05, 4)


def flux(is_held, offset):
    """Record the flux of a motor and its speed; of two currents only that of the speed jumps."""
    dt, n_parts, rng = 0.02, 10, np.random.default_rng(1)
    t = np.arange(0.0, 80.0, dt / n_parts)
    now = t - t % dt if is_held else t
    field = 2.0 + 0.5 * np.sin(0.7 * (now + 1e-9))
    torque = np.repeat(rng.uniform(-1.0, 1.0, 80), len(t) // 80)
    x = np.array([[1.0, 0.0]] + [[0.0, 0.0]] * (len(t) - 1))
    for k in range(len(t) - 1):
        flux, speed = x[k]
        slopes = np.array([0.8 * field[k] - 1.6 * flux + offset, 3.0 * torque[k] - 0.4 * speed])
        x[k + 1] = x[k] + dt / n_parts * slopes
    u = np.column_stack([2.0 + 0.5 * np.sin(0.7 * t), torque])[::n_parts]
    y = x[::n_parts] + [0.002, 0.01] * rng.standard_normal((len(u), 2))
    return pse.prepare(t[::n_parts], y, u, order=1, held=[1])


@pytest.mark.parametrize(
    ("is_held", "offset", "told", "taken"),
    [(True, 0.0, False, True), (False, -0.02, False, False), (True, 0.0, True, False)],
)
def test_a_smooth_input_beside_one_that_is_held_is_held_if_an_effect_does_no_better(
    is_held, offset, told, taken
):
    """Half a sample late, a sine differs from itself by what two parameters and an offset do."""
    record = flux(is_held, offset)
    sides = {"l": "m*d - n*l", "w": "k*q - c*w"}
    design = pse.DeclaredModel(sides, inputs=["d", "q"]).design()
    effect = Candidate("constant offset", 0, (OFFSET,))
    named = Finding(effect, columns_of(effect, design), 0.1, 0.016, np.zeros(60))
    found = Found(design, [record], segments([record]), RULES, (), (named,), holds_are_told=told)
    again = with_holds(found)
    assert (again is not None) is taken
    if again is not None:
        assert again.held == {0: 0.5, 1: 0.5}
        assert again.findings == ()


def test_no_hold_replaces_an_effect_that_explains_as_little():
    """A drag that only free runs show scores nothing in the derivative, and so did the hold."""
    record = flux(is_held=False, offset=0.0)
    design = pse.DeclaredModel({"l": "m*d - n*l", "w": "k*q - c*w"}, inputs=["d", "q"]).design()
    effect = Candidate("quadratic drag", 1, (mul(variable(1), call(BUILTIN["abs"], variable(1))),))
    assert not hold_replaces(effect, 0, design, segments([record]))
