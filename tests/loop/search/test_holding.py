"""Inputs that turn out to be held when all else was found."""

from types import SimpleNamespace

import pytest
from loop_systems import regulated

import pysindy_evolve as pse
from pysindy_evolve.loop.given.held import held_where_it_may_be
from pysindy_evolve.loop.given.segments import segments
from pysindy_evolve.loop.search.holding import take_holds


@pytest.mark.parametrize("is_held", [True, False])
def test_a_hold_that_no_effect_was_found_beside_is_taken(is_held):
    """Damping is missing: without it the hold does worse, and without the hold it does."""
    record, taken = regulated(is_held, 8), {}
    design = pse.DeclaredModel({"q": "v", "v": "b*M"}, inputs=["M"]).design()

    def pieces_with(findings, late):
        return segments([held_where_it_may_be(record, late)])

    search = SimpleNamespace(declared=design, design=design, findings=[], pieces_with=pieces_with)
    search.corrected_pieces = segments([record])
    search.take_as_held = lambda late, holding: taken.update(late)
    assert take_holds(search) is is_held
    assert taken == ({0: 0.5} if is_held else {})
