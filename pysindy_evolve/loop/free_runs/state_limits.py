"""Limits of a state itself, not only of its sensor.

Such a state stops at the limit, and leaves it as soon as it is driven back. If only the sensor has
a limit, the state goes on unseen, and shows again when it has come back. Free runs over training
records tell which of the two it is; if they do not, the readings are taken as true.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...signals import Record
from ..effects.candidate import Candidate
from ..evidence.findings import LimitFinding
from ..evidence.shares import is_exact
from ..fitting.fit import refit
from ..given.design import Design
from ..given.limits import LIMITED, Limit, limits_of
from ..given.rules import Rules
from ..given.segments import segments
from ..given.sticking import may_rest
from .drift import Drift, drift_of, gains_of_models
from .plateaus import limits_beyond_chance
from .variants import Model


def stops_of(
    model: Model, records: Sequence[Record], rules: Rules, rng: np.random.Generator
) -> list[LimitFinding]:
    """Return the limits at which states of the first order may stop.

    Records stay there for longer than twins without the limit do. There are none if the records
    already mark clipped readings as unseen.
    """
    if any(record.seen is not None for record in records):
        return []
    shown = [one for one in limits_of(records) if _may_stop(one, model.design, records)]
    if not shown:
        return []
    acted = model.acted(records)
    equations = model.design.equations(refit(model.design, acted, "derivative"))
    found = []
    beyond = limits_beyond_chance(shown, equations, acted, rules, rng)
    for limit, length, p_value, lengths in beyond:
        candidate = Candidate(LIMITED, limit.state, (limit.term,))
        evidence = float(length), p_value, lengths
        found.append(LimitFinding(candidate, (), *evidence, by_runs=True, limit=limit))
    return found


def may_stop_itself(
    design: Design, records: Sequence[Record], rules: Rules, rng: np.random.Generator
) -> bool:
    """Tell whether clipped readings may be true values, since the state itself stops there.

    They may, unless the runs are notably closer to the record if only the sensor has the limit. A
    model that lacks much cannot tell the two apart.
    """
    if all(record.seen is None for record in records) or design.algebraic:
        return False
    plain, believed = Model(design), [replace(record, seen=None) for record in records]
    stops = stops_of(plain, believed, rules, rng.spawn(1)[0])
    model = replace(plain, limits=tuple(one.limit for one in stops))
    return bool(stops) and _gain(model, plain, records) > -rules.notable_gain


def _may_stop(limit: Limit, design: Design, records: Sequence[Record]) -> bool:
    made = records[0].preparation
    return made is not None and made.order == 1 and limit.state in design.open_states


def needed(
    model: Model, stops: Sequence[LimitFinding], records: Sequence[Record], rules: Rules
) -> list[LimitFinding]:
    """Return the limits without which the runs, seen through the sensors, get notably worse."""
    kept = []
    for stop in stops:
        others = tuple(f.limit for f in stops if f is not stop)
        without = replace(model, limits=others)
        with_all = replace(model, limits=(*others, stop.limit))
        if _gain(with_all, without, records) >= rules.notable_gain:
            kept.append(stop)
    return kept


def _gain(model: Model, other: Model, records: Sequence[Record]) -> float:
    """Return log(error of `other` / error of `model`); 0 if `other` cannot be run."""
    drift = drift_from(other, records)
    return 0.0 if drift is None else float(gains_of_models(drift, [model])[0, 0])


def drift_from(model: Model, records: Sequence[Record]) -> Drift | None:
    """Return the drift of a model; None if it has no columns, is exact, or cannot be run."""
    acted = model.acted(records)
    part = segments(acted, may_rest(model.design, acted))
    if not model.design.columns or is_exact(model.design, part):
        return None
    return drift_of(model, refit(model.design, acted, "derivative"), records)
