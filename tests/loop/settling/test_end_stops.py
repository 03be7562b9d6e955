"""A stop stands on the steep side of its end, if spring and offset beside it leave that open."""

import numpy as np
import pytest
from loop_systems import oscillator

from pysindy_evolve.loop.effects.candidate import CandidateMaker
from pysindy_evolve.loop.effects.stops import is_stop, stops
from pysindy_evolve.loop.evidence.findings import Finding, with_findings
from pysindy_evolve.loop.evidence.scoring import columns_of
from pysindy_evolve.loop.given.declared import design_of
from pysindy_evolve.loop.given.segments import segments
from pysindy_evolve.loop.settling.other_names import on_steep_side
from pysindy_evolve.terms import variable


@pytest.mark.parametrize("declared", ["-k*q - c*v + b*F + o", "-k*q - c*v + b*F"])
@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize("place", [0.3, -0.3])
def test_a_stop_stands_on_the_steep_side_where_spring_and_offset_leave_that_open(
    declared, side, place
):
    hidden = oscillator("dead zone", f"- {side * 300}*max({side}*(q - {place}), 0)", declared)
    record = hidden.record()
    design, part = design_of(hidden.model, [record]), segments([record])
    places = filter(is_stop, stops(CandidateMaker(1), variable(0), 1.0, 0.0))
    q = np.linspace(-1.0, 1.0, 41)[:, None]
    beyond = np.maximum(side * (q[:, 0] - place), 0.0)
    for stop in (place.at([0.3]) for place in places):
        if stop.shape.branch * place < 0.0:
            continue
        finding = Finding(stop, columns_of(stop, design), 1.0, 0.016, np.zeros(60), 1)
        told = on_steep_side(finding, with_findings(design, [finding]), part)
        if declared.endswith("o"):
            assert told.candidate.terms[0].evaluate(q) == pytest.approx(beyond)
        else:
            assert told is finding
