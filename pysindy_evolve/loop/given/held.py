"""Which inputs are held between their samples, in records that may have been driven differently."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ...signals import Record
from ...signals.zero_order_hold import acting_through, hold
from .input_errors import may_be_held


def held_inputs(records: Sequence[Record]) -> dict[int, float]:
    """Return the inputs that any of the records holds, and by how many samples each is late."""
    return {column: late for record in records for column, late in record.held.items()}


def held_where_it_may_be(record: Record, late: Mapping[int, float]) -> Record:
    """Return a record with inputs held, except those that were clearly driven smoothly.

    A record made by a user has no raw inputs, so any of its inputs may be held.
    """
    unknown = record.preparation is None
    held = {k: share for k, share in late.items() if unknown or may_be_held(record, k)}
    return hold(record, held)


def held_like(record: Record, others: Sequence[Record]) -> Record:
    """Return a record with inputs held as in others; those that only some hold, if they may be."""
    late = held_inputs(others)
    always = {k: share for k, share in late.items() if all(k in other.held for other in others)}
    if not record.through:
        record = acting_through(record, others[0].through)
    return held_where_it_may_be(hold(record, always), late)
