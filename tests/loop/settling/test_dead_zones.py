"""A clipped input is called a dead zone where hardly any slope is left inside of the limits."""

import numpy as np
import pytest
from loop_systems import oscillator

from pysindy_evolve.loop.effects.missing import candidates
from pysindy_evolve.loop.evidence.findings import Finding, with_findings
from pysindy_evolve.loop.evidence.scoring import columns_of
from pysindy_evolve.loop.given.declared import design_of
from pysindy_evolve.loop.given.segments import segments
from pysindy_evolve.loop.settling.other_names import as_dead_zone


@pytest.mark.parametrize(
    ("lacking", "name"),
    [
        ("- 0.5*(abs(F + 12) - abs(F - 12))", "dead zone"),
        ("- F + 0.5*(abs(F + 12) - abs(F - 12))", "saturation"),
        ("- 0.45*(abs(F + 12) - abs(F - 12))", "dead zone"),
        ("- 0.2*(abs(F + 12) - abs(F - 12))", "saturation"),  # most of the slope is left inside
        ("+ 0.2*(abs(F + 12) - abs(F - 12))", "saturation"),
    ],
)
def test_a_clipped_input_is_called_what_it_is(lacking, name):
    hidden = oscillator(name, lacking)
    record = hidden.record()
    design, part = design_of(hidden.model, [record]), segments([record])
    offered = candidates(design, part.ranges)
    clipped = [c for c in offered if c.name == "saturation"]
    near = min(clipped, key=lambda c: abs(c.shape.values[0] - 12.0))
    finding = Finding(near, columns_of(near, design), 1.0, 0.016, np.zeros(60), 1)
    told = as_dead_zone(finding, with_findings(design, [finding]), part)
    assert told.candidate.name == name
    assert told.columns == finding.columns
    meaning = "half width" if name == "dead zone" else "limit"
    assert list(told.candidate.shape.named) == [meaning]
