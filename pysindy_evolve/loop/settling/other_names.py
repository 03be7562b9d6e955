"""Effects under the names that are right beside all others that were found.

- Friction that differs with the direction is an offset and a friction: -a for v > 0 and b for
  v < 0 is -(a + b)/2 sgn(v) - (a - b)/2. No record can tell the two, so where both parts were found
  the other name belongs to them.
- A dead zone of an input and its saturation are both the input, clipped at a number. Beside the
  input itself the clipped one changes the slope inside of the limits. Where hardly any of it is
  left there, the input has a dead zone.
- Beside a spring and an offset max(q - c, 0) and max(c - q, 0) are one force, with another spring.
  Of the two, the stop is the one beyond which the force is steeper.
- A grown product with another state in it is a coupling, as of the speeds about two other axes. So
  is what turns one axis with the speed of a rotor, an input, times that of another axis.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...terms import Variable, variable
from ..effects.candidate import OFFSET, Candidate
from ..effects.inputs import clipped_input
from ..effects.missing import fitted_terms
from ..effects.names import (
    ASYMMETRIC_FRICTION,
    CONSTANT_OFFSET,
    COULOMB_FRICTION,
    COUPLING,
    DEAD_ZONE,
    EVOLVED,
    SATURATION,
)
from ..effects.stops import begun_at_same, ends_of, is_stop
from ..evidence.findings import Finding, with_findings
from ..evidence.scoring import quick_fit
from ..given.design import Design
from ..given.segments import Segments

MOST_LEFT = 0.5  # of the slope, inside of a dead zone
# Of the largest magnitude of the position: how far from its end a stop is looked at.
DISTANCE_FROM_END = 1e-3


def renamed(declared: Design, findings: Sequence[Finding], part: Segments) -> list[Finding]:
    """Return findings under their right names, in the same order.

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
    told = _with_asymmetry(findings)
    whole = with_findings(declared, told)
    told = [as_dead_zone(finding, whole, part) for finding in told]
    told = [on_steep_side(finding, whole, part) for finding in told]
    return [as_coupling(finding, declared) for finding in told]


def _with_asymmetry(findings: Sequence[Finding]) -> list[Finding]:
    """Return findings in which friction beside an offset knows its other name."""
    states = {
        name: {f.candidate.state for f in findings if f.candidate.name == name}
        for name in (COULOMB_FRICTION, CONSTANT_OFFSET, ASYMMETRIC_FRICTION)
    }
    there = (states[COULOMB_FRICTION] & states[CONSTANT_OFFSET]) - states[ASYMMETRIC_FRICTION]
    return [
        replace(f, together=(ASYMMETRIC_FRICTION,))
        if f.candidate.state in there and f.candidate.name in (COULOMB_FRICTION, CONSTANT_OFFSET)
        else f
        for f in findings
    ]


def as_dead_zone(finding: Finding, whole: Design, part: Segments) -> Finding:
    """Return a clipped input under the name of a dead zone, if it is one.

    `whole` is the model with all findings.
    """
    candidate, shape = finding.candidate, finding.candidate.shape
    if candidate.name != SATURATION or shape is None or not finding.columns:
        return finding
    low, high = ends_of(shape)
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    values = middle + np.array([-0.5, 0.5, 1.1, 1.5]) * half
    _, rate = _rates_over(clipped_input(candidate), values, candidate.state, whole, part)
    inside, outside = (rate[1] - rate[0]) / half, (rate[3] - rate[2]) / (0.4 * half)
    if abs(inside) >= MOST_LEFT * abs(outside):
        return finding
    meanings = ("half width",) if len(shape.values) == 1 else shape.meanings
    zone = replace(candidate, name=DEAD_ZONE, shape=replace(shape, meanings=meanings))
    return replace(finding, candidate=zone)


def on_steep_side(finding: Finding, whole: Design, part: Segments) -> Finding:
    """Return a stop of one position on the steeper side, if the model leaves open on which it is.

    `whole` is the model with all findings.
    """
    candidate, shape = finding.candidate, finding.candidate.shape
    if shape is None or not is_stop(candidate) or candidate.partners:
        return finding
    if len(candidate.variables) != 1:
        return finding
    (position,) = candidate.variables
    spring_and_offset = {(candidate.state, OFFSET), (candidate.state, variable(position))}
    if not spring_and_offset <= fitted_terms(whole):
        return finding
    step = DISTANCE_FROM_END * float(np.abs(part.z[..., position]).max())
    values = shape.branch * shape.values[0] + step * np.array([-1.0, 0.0, 1.0])
    rows, rate = _rates_over(position, values, candidate.state, whole, part)
    slope_below, slope_above = np.abs(np.diff(rate))
    below, _, above = candidate.terms[0].evaluate(rows)
    if bool(slope_above > slope_below) == bool(above > below):
        return finding
    (other,) = begun_at_same(candidate)
    return finding.with_candidate(other, whole)


def _rates_over(
    place: int, values: np.ndarray, state: int, design: Design, part: Segments
) -> tuple[np.ndarray, np.ndarray]:
    """Return rows in which one variable has some values, all others their means, and the rates."""
    rows = np.tile(part.z[..., :-1].mean(axis=(0, 1)), (len(values), 1))
    rows[:, place] = values
    n = part.n_states
    rates = quick_fit(design, part).evaluate(rows[:, :n], rows[:, n:], np.zeros(len(rows)))
    return rows, rates[:, state]


def as_coupling(finding: Finding, design: Design) -> Finding:
    """Return a grown product with another state in it under the name of a coupling.

    The vocabulary holds those of a state itself with another one; all of them would be many.
    """
    candidate = finding.candidate
    if candidate.name != EVOLVED or not _is_product(design, candidate):
        return finding
    return replace(finding, candidate=replace(candidate, name=COUPLING))


def _is_product(design: Design, candidate: Candidate) -> bool:
    own = {candidate.state, design.position_of(candidate.state)}
    acting = candidate.variables
    parts = [part for term in candidate.terms for _, part in term.parts]
    atoms = [atom for part in parts for atom, _ in part.factors]
    is_one = len(parts) == 1 and all(isinstance(atom, Variable) for atom in atoms)
    others = acting & set(range(len(design.states))) - own
    return is_one and len(atoms) > 1 and bool(others) and design.time not in acting
