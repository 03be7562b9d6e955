"""Inputs that turn out to be held when all else was found."""

import pytest
from loop_systems import regulated

import pysindy_evolve as pse
from pysindy_evolve.loop.given.rules import Rules
from pysindy_evolve.loop.given.segments import segments
from pysindy_evolve.loop.search.found import Found
from pysindy_evolve.loop.search.how_inputs_act import with_holds


@pytest.mark.parametrize("is_held", [True, False])
def test_a_hold_that_no_effect_was_found_beside_is_taken(is_held):
    """Damping is missing: without it the hold does worse, and without the hold it does."""
    record = regulated(is_held, 8)
    design = pse.DeclaredModel({"q": "v", "v": "b*M"}, inputs=["M"]).design()
    taken = with_holds(Found(design, [record], segments([record]), Rules(0.05, 59, 0.05, 4), ()))
    assert (taken is not None) == is_held
    if taken is not None:
        assert taken.held == {0: 0.5}
