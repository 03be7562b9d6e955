"""Drop effects of inputs alone that remove no more from free runs than input noise adds.

This repeats the test of errors_in_inputs.py for free runs, which show effects that the noise of a
derivative hides. A hammer's force, for example, is only noise between blows. A function that is
flat at zero removes this noise, and runs come closer to the record though nothing is missing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...signals import Record
from ..evidence.findings import Finding, excluding
from ..fitting.trial import Rows, converged, runs_of
from ..free_runs.drift import Drift
from ..free_runs.judging import model_of
from ..free_runs.state_limits import drift_from
from ..given.design import Design
from ..given.input_errors import input_error
from .errors_in_inputs import MIN_POWER_OVER_ERRORS, N_DRAWS, is_of_inputs


def without_noise_in_runs(
    declared: Design,
    findings: Sequence[Finding],
    records: Sequence[Record],
    rng: np.random.Generator,
) -> list[Finding]:
    """Return findings without those of inputs alone that only remove input noise from free runs.

    Parameters
    ----------
    declared : Design
        The declared model.
    findings : sequence of Finding
        What was found.
    records : sequence of Record
        Training records, before memories are applied.
    rng : numpy.random.Generator
        Draws the noise.

    Returns
    -------
    list of Finding
        All of them if the model cannot be run.
    """
    kept = list(findings)
    for finding in findings:
        if is_of_inputs(finding, declared) and _is_noise(finding, declared, kept, records, rng):
            kept = excluding(kept, finding)
    return kept


def _is_noise(
    finding: Finding,
    declared: Design,
    found: Sequence[Finding],
    records: Sequence[Record],
    rng: np.random.Generator,
) -> bool:
    rest = excluding(found, finding)
    drift = drift_from(model_of(declared, rest), records)
    rows = None if drift is None else drift.trial.rows()
    if drift is None or rows is None:
        return False
    (with_it,) = converged([drift.trial_of(model_of(declared, [*rest, finding]))])
    inputs = frozenset(v - len(declared.states) for v in finding.candidate.variables)
    drawn = [_moved_by_noise(drift, inputs, child) for child in rng.spawn(N_DRAWS)]
    removed = _power(rows, drift.trial.miss) - _power(rows, with_it.miss)
    by_noise = float(np.mean([_power(rows, moved) for moved in drawn]))
    return removed <= MIN_POWER_OVER_ERRORS * by_noise


def _moved_by_noise(drift: Drift, inputs: frozenset[int], rng: np.random.Generator) -> np.ndarray:
    """Return by how much noise on inputs moves the runs of a model, (n_stretches, n, n_states)."""
    trial, part = drift.trial, drift.trial.part
    errors = [_error(record, rng, inputs) for record in drift.records]
    z = part.z.copy()
    z[:, :, part.n_states : -1] += part.cut(errors)
    (noisy,) = runs_of([replace(trial, part=replace(part, z=z))])
    return np.asarray(part.shown(noisy.x) - trial.shown)


def _error(record: Record, rng: np.random.Generator, inputs: frozenset[int]) -> np.ndarray:
    error = input_error(record, rng, inputs)
    return np.zeros((record.n_samples, record.n_inputs)) if error is None else error


def _power(rows: Rows, missed: np.ndarray) -> float:
    """Return the power of misses, (n_stretches, n, n_states), that changed starts leave."""
    return float(np.mean(rows.without_starts(rows.of(missed)) ** 2))
