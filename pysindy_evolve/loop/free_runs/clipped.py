"""Sensors that clip: a reading ends where the state goes on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from ...signals import Record
from ..effects.candidate import Candidate
from ..evidence.step import Finding
from ..fitting.fit import refit
from ..given.rules import Rules
from .limits import LIMITED, Limit, limits_of, tested
from .variants import Model

__all__ = ["SensorFinding", "clipped_sensors"]


@dataclass(frozen=True, eq=False)
class SensorFinding(Finding):
    """An end of the range of a sensor. It changes no equation, but what is read of a state."""

    limit: Limit = field(kw_only=True)


def clipped_sensors(
    model: Model,
    findings: Sequence[Finding],
    records: Sequence[Record],
    rules: Rules,
    rng: np.random.Generator,
) -> list[Finding]:
    """Return findings with the limits of readings that no state has met.

    Parameters
    ----------
    model : Model
        The corrected model, with the limits that states have met.
    findings : sequence of Finding
        What was found before.
    records : sequence of Record
        Training records without memories.
    rules : Rules
        When a limit counts.
    rng : numpy.random.Generator
        Draws the noise of the twins.

    Returns
    -------
    list of Finding
        All sensors share one step.
    """
    met = {(limit.state, limit.upper) for limit in model.limits}
    limits = [one for one in limits_of(records) if (one.state, one.upper) not in met]
    if not limits or all(record.seen is None for record in records):
        return list(findings)
    acted, step = model.acted(records), 1 + max((f.step for f in findings), default=0)
    equations = model.whole.equations(refit(model.whole, acted, "derivative"))
    found: list[Finding] = []
    for limit, length, p_value, lengths in tested(limits, equations, acted, rules, rng.spawn(1)[0]):
        candidate = Candidate(LIMITED, limit.state, (limit.reading,))
        own = (candidate, (), float(length), p_value, lengths)
        found.append(SensorFinding(*own, step=step, limit=limit))
    return [*findings, *found]
