"""Sensors that clip: a reading ends where the state goes on."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...signals import Record
from ..effects.candidate import Candidate
from ..evidence.findings import Finding, SensorFinding, next_step
from ..fitting.fit import refit
from ..given.limits import LIMITED, limits_of
from ..given.rules import Rules
from .plateaus import limits_beyond_chance
from .variants import Model


def clipped_sensors(
    model: Model,
    findings: Sequence[Finding],
    records: Sequence[Record],
    rules: Rules,
    rng: np.random.Generator,
) -> list[Finding]:
    """Add the limits of readings that are limits of the sensor, not of the state.

    Parameters
    ----------
    model : Model
        The corrected model, with the limits at which states stop.
    findings : sequence of Finding
        What was found before.
    records : sequence of Record
        Training records, before memories are applied.
    rules : Rules
        When a limit counts.
    rng : numpy.random.Generator
        Draws the noise of the twins.

    Returns
    -------
    list of Finding
        All limits of sensors share one step.
    """
    of_states = {(limit.state, limit.upper) for limit in model.limits}
    limits = [one for one in limits_of(records) if (one.state, one.upper) not in of_states]
    if not limits or all(record.seen is None for record in records):
        return list(findings)
    acted, step = model.acted(records), next_step(findings)
    equations = model.whole.equations(refit(model.whole, acted, "derivative"))
    found: list[Finding] = []
    beyond = limits_beyond_chance(limits, equations, acted, rules, rng.spawn(1)[0])
    for limit, length, p_value, lengths in beyond:
        candidate = Candidate(LIMITED, limit.state, (limit.reading,))
        evidence = float(length), p_value, lengths
        found.append(SensorFinding(candidate, (), *evidence, step=step, limit=limit))
    return [*findings, *found]
