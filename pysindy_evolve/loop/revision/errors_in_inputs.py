"""Drop effects of inputs alone that explain no more than the errors of these inputs.

No model explains the noise of an input's sensor, or what the input did between two samples. Where
an input rests at levels, a function that is flat there removes much of this noise, so that a
complete model seems to lack a saturation. (Carroll et al., Measurement Error in Nonlinear Models,
2006, call the reason regression calibration: the best guess of a true value is no linear function
of the measured one.)
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

N_DRAWS = 4  # of the noise
# Power that an effect explains over that of these errors; less may be chance.
MIN_POWER_OVER_ERRORS = 1.25


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
        The declared model.
    findings : sequence of Finding
        What was found.
    raw : sequence of Record
        Training records before memories, which would smooth the noise of the inputs.
    part : Segments
        Pieces of the same records after the memories among the findings.
    rng : numpy.random.Generator
        Draws the noise.

    Returns
    -------
    list of Finding
        The least useful one is dropped first, and the others are judged again.
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
        if worth[least] > MIN_POWER_OVER_ERRORS:
            break
        kept.remove(suspects.pop(least))
    return kept


def is_of_inputs(finding: Finding, declared: Design) -> bool:
    """Tell whether a finding is a nonlinear function of inputs alone; a gain hides no noise."""
    first = len(declared.states)
    inputs = set(range(first, first + len(declared.inputs)))
    nonlinear, variables = not finding.candidate.is_straight, finding.candidate.variables
    return bool(finding.columns) and nonlinear and bool(variables) and variables <= inputs


def _worth(finding: Finding, declared: Design, found: Sequence[Finding], part: Segments) -> float:
    """Return the residual power of its equation that a finding removes."""
    fewer = with_findings(declared, excluding(found, finding))
    sides = fewer, with_findings(declared, found)
    without, with_it = (_residual_power(quick_fit(design, part), part) for design in sides)
    return float((without - with_it)[finding.candidate.state])


def _residual_power(equations: Equations, part: Segments) -> np.ndarray:
    """Return the residual power of equations, (n_states,)."""
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
    """Return the power that errors of its inputs add to the residual of a finding's equation."""
    inputs = frozenset(v - part.n_states for v in finding.candidate.variables)
    pairs, powers = list(zip(raw, part.records, strict=True)), []
    for rng in drawn:
        moved = [_moved_by_errors(equations, *pair, inputs, rng) for pair in pairs]
        powers.append(_power(part.cut(moved), part))
    return float(np.mean(powers, axis=0)[finding.candidate.state])


def _moved_by_errors(
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
    """Return the power of columns (n_segments, n, n_states) at the frequencies of the search."""
    return np.mean(np.abs(spectral_rows(part, columns * part.weight)) ** 2, axis=(0, 1))
