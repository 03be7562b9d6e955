"""Tell a dead zone of an input from its saturation: both are the input, clipped at a number.

Beside the input itself the clipped one changes the slope inside of the limits. Where hardly any of
it is left there, the input has a dead zone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...equations import Equations
from ..effects.candidate import Candidate
from ..effects.inputs import clipped_input
from ..effects.names import DEAD_ZONE, SATURATION
from ..effects.stops import ends_of
from ..evidence.findings import Finding, with_findings
from ..evidence.scoring import quick_fit
from ..given.design import Design
from ..given.segments import Segments

__all__ = ["with_dead_zones_named"]

MOST_LEFT = 0.5  # of the slope, inside of a dead zone


def with_dead_zones_named(
    declared: Design, findings: Sequence[Finding], part: Segments
) -> list[Finding]:
    """Return findings in which a clipped input is called what it is.

    Parameters
    ----------
    declared : Design
        The model at the start.
    findings : sequence of Finding
        What was found.
    part : Segments
        Pieces of the training records.

    Returns
    -------
    list of Finding
    """
    told = []
    for finding in findings:
        candidate = finding.candidate
        if candidate.name == SATURATION and candidate.shape is not None and finding.columns:
            equations = quick_fit(with_findings(declared, findings), part)
            inside, outside = _slopes(candidate, ends_of(candidate.shape), equations, part)
            if abs(inside) < MOST_LEFT * abs(outside):
                alone = len(candidate.shape.values) == 1
                meanings = ("half width",) if alone else candidate.shape.meanings
                shape = replace(candidate.shape, meanings=meanings)
                zone = replace(candidate, name=DEAD_ZONE, shape=shape)
                finding = replace(finding, candidate=zone)
        told.append(finding)
    return told


def _slopes(
    candidate: Candidate, ends: tuple[float, float], equations: Equations, part: Segments
) -> tuple[float, float]:
    """Return the slopes of a rate over a clipped input, inside and above its ends."""
    place = clipped_input(candidate)
    n_states = part.n_states
    rows = np.tile(part.z[..., :-1].mean(axis=(0, 1)), (4, 1))
    middle, half = 0.5 * (ends[0] + ends[1]), 0.5 * (ends[1] - ends[0])
    rows[:, place] = middle + np.array([-0.5, 0.5, 1.1, 1.5]) * half
    rates = equations.evaluate(rows[:, :n_states], rows[:, n_states:], np.zeros(4))
    rate = rates[:, candidate.state]
    return float((rate[1] - rate[0]) / half), float((rate[3] - rate[2]) / (0.4 * half))
