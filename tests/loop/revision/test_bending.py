"""A coefficient that varies in proportion to a variable gives way to a hyperbola that fits."""

import numpy as np
import pytest
from loop_systems import oscillator

from pysindy_evolve.loop.effects.candidate import Candidate
from pysindy_evolve.loop.evidence.findings import Finding
from pysindy_evolve.loop.evidence.scoring import columns_of
from pysindy_evolve.loop.given.segments import segments
from pysindy_evolve.loop.revision.bending import with_hyperbolas
from pysindy_evolve.terms import power, variable

SQUARE = Candidate("quadratic stiffness", 1, (power(variable(0), 2),))


def after(term):
    """Return the square of the position as found, looked at again on a record."""
    machine = oscillator("quadratic stiffness", term, size=8.0)
    record, design = machine.record(duration=20.0), machine.model.design()
    found = Finding(SQUARE, columns_of(SQUARE, design), 1.0, 0.01, np.zeros(9))
    (kept,) = with_hyperbolas(design, [found], segments([record]))
    return kept.candidate


def test_the_stiffness_of_a_string_is_a_hyperbola():
    """With 1 / (1 - q/L) it is the declared one times 1 + q/(L - q)."""
    candidate = after("- 40*q*q/(1.5 - q)")
    assert candidate.shape is not None
    assert candidate.shape.values == pytest.approx((1.5,), rel=0.02)
    assert candidate.shape.meanings == ("length",)


def test_a_stiffness_that_varies_in_proportion_stays():
    assert after("- 10*q**2") is SQUARE
