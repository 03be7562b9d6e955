"""Inputs before the records began, and memories of inputs tuned with them.

Memories are found as if the inputs had long stood at their first values. For a heater that is
switched on with the first sample, that is wrong. The first rows show it, and with the right input
before the record the time constant changes.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...equations import Equations
from ...hidden_states.memory import all_with_memories
from ...hidden_states.memory_equations import with_memories
from ...signals import Record
from ..evidence.findings import Finding, memories_in, with_findings
from ..evidence.scoring import quick_fit
from ..fitting.past import with_estimated_past
from ..given.design import Design
from ..given.segments import Segments
from ..memories.memory_search import resettled

N_ROUNDS = 6  # of estimating past inputs and tuning memories in turn


def settled_beginning(
    declared: Design, findings: Sequence[Finding], plain: Sequence[Record], part: Segments
) -> tuple[list[Finding], tuple[Record, ...], tuple[Record, ...]]:
    """Return findings with memories tuned again, given the inputs before the records began.

    Parameters
    ----------
    declared : Design
        The declared model.
    findings : sequence of Finding
        What was found, memories included.
    plain : sequence of Record
        Training records, before memories are applied.
    part : Segments
        Pieces of the same records in a wider filter.

    Returns
    -------
    findings : list of Finding
        The same with their memories tuned.
    plain, wide : tuple of Record
        The records in both filters, with past inputs that fit their first rows.
    """
    design, found = with_findings(declared, findings), list(findings)
    plain, wide = tuple(plain), part.records
    for _ in range(N_ROUNDS):
        memories = memories_in(found)
        acted = part.of(all_with_memories(wide, memories))
        equations = quick_fit(design, acted)
        model = with_memories(equations, memories)
        elsewhere = [not _begins_alike(*both) for both in zip(part.records, wide, strict=True)]
        previous, wide = wide, _with_estimated_pasts(model, wide, elsewhere)
        if all(_begins_alike(*both) for both in zip(previous, wide, strict=True)):
            break
        plain = _with_estimated_pasts(model, plain, elsewhere)
        found = resettled(found, design, part.with_pasts_of(wide))
    return found, plain, wide


def _with_estimated_pasts(
    model: Equations, records: Sequence[Record], elsewhere: Sequence[bool]
) -> tuple[Record, ...]:
    """Estimate past inputs again; where they are known to differ, errors need not exceed noise."""
    pairs = zip(records, elsewhere, strict=True)
    return tuple(with_estimated_past(model, record, doubted=is_known) for record, is_known in pairs)


def _begins_alike(record: Record, other: Record) -> bool:
    return np.array_equal(record.raw_u, other.raw_u)
