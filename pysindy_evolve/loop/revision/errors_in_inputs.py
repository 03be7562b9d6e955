"""Drop effects of inputs alone that explain no more than the errors of these inputs.

The noise of a sensor, and whatever an input did between two samples, are left by any model. Where
an input rests at levels, a function of it that is flat there takes a good part of this noise off:
a record that lacks nothing seems to lack a saturation. (Carroll et al., Measurement Error in
Nonlinear Models, 2006, call the reason regression calibration: the best guess of a true value is no
linear function of the measured one.)
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...checks import TINY
from ...equations import Equations
from ...signals import Record
from ..evidence.findings import Finding, excluding, with_findings
from ..evidence.scoring import quick_fit
from ..evidence.spectral import spectral_rows
from ..given.design import Design
from ..given.input_errors import input_error
from ..given.segments import Segments

__all__ = ["EXCESS", "N_DRAWS", "is_of_inputs", "without_errors_in_inputs"]

N_DRAWS = 4  # of the noise
EXCESS = 1.25  # times the power of these errors; less may be a matter of chance


def without_errors_in_inputs(
    declared: Design,
    findings: Sequence[Finding],
    raw: Sequence[Record],
    part: Segments,
    rng: np.random.Generator,
) -> list[Finding]:
    """Return findings without those of inputs alone that explain only the errors of the inputs.

    Parameters
    ----------
    declared : Design
        The model at the start.
    findings : sequence of Finding
        What was found.
    raw : sequence of Record
        Training records.
    part : Segments
        Pieces of the same with the memories among the findings, which would take noise off the
        inputs.
    rng : numpy.random.Generator
        Draws the noise.

    Returns
    -------
    list of Finding
        The least useful one falls first, and the others are looked at again.
    """
    kept = list(findings)
    suspects = [f for f in kept if is_of_inputs(f, declared)]
    rest = with_findings(declared, [f for f in kept if f not in suspects])
    if not suspects:
        return kept
    equations, drawn = quick_fit(rest, part), rng.spawn(N_DRAWS)
    errors = {f: _power_of_errors(equations, f, raw, part, drawn) for f in suspects}
    while suspects:
        worth = [_worth(f, declared, kept, part) / max(errors[f], TINY) for f in suspects]
        least = int(np.argmin(worth))
        if worth[least] > EXCESS:
            break
        kept.remove(suspects.pop(least))
    return kept


def is_of_inputs(finding: Finding, declared: Design) -> bool:
    """Tell whether a finding is a function of inputs alone that bends: a gain hides no noise."""
    first = len(declared.states)
    inputs = set(range(first, first + len(declared.inputs)))
    bent, variables = not finding.candidate.is_straight, finding.candidate.variables
    return bool(finding.columns) and bent and bool(variables) and variables <= inputs


def _worth(finding: Finding, declared: Design, found: Sequence[Finding], part: Segments) -> float:
    """Return the power that a finding takes off what is left of its equation."""
    fewer = with_findings(declared, excluding(found, finding))
    sides = fewer, with_findings(declared, found)
    without, beside = (_left(quick_fit(design, part), part) for design in sides)
    return float((without - beside)[finding.candidate.state])


def _left(equations: Equations, part: Segments) -> np.ndarray:
    """Return the power of what equations leave, (n_states,)."""
    z, n = part.rows, part.n_states
    rates = equations.evaluate(z[:, :n], z[:, n:-1], z[:, -1])
    return _power(part.x_dot - rates.reshape(part.x_dot.shape), part)


def _power_of_errors(
    equations: Equations,
    finding: Finding,
    raw: Sequence[Record],
    part: Segments,
    drawn: Sequence[np.random.Generator],
) -> float:
    """Return the power that errors of its inputs leave in the equation of a finding."""
    inputs = frozenset(v - part.n_states for v in finding.candidate.variables)
    pairs, powers = list(zip(raw, part.records, strict=True)), []
    for rng in drawn:
        left = [_of_record(equations, *pair, inputs, rng) for pair in pairs]
        powers.append(_power(part.cut(left), part))
    return float(np.mean(powers, axis=0)[finding.candidate.state])


def _of_record(
    equations: Equations,
    raw: Record,
    record: Record,
    inputs: frozenset[int],
    rng: np.random.Generator,
) -> np.ndarray:
    error = input_error(raw, rng, inputs)
    if error is None or record.u is None:
        return np.zeros_like(record.x_dot)
    moved = equations.evaluate(record.x, record.u + error, record.t)
    return np.asarray(moved - equations.evaluate(record.x, record.u, record.t))


def _power(columns: np.ndarray, part: Segments) -> np.ndarray:
    """Return the power of columns (n_segments, n, n_states) at the frequencies looked at."""
    return np.mean(np.abs(spectral_rows(part, columns * part.weight)) ** 2, axis=(0, 1))
