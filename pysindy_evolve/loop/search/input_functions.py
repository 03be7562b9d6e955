"""Inputs that jump, and act through functions that were found: they are filtered after these."""

from __future__ import annotations

from collections.abc import Sequence

from ...signals import Record
from ...signals.zero_order_hold import acting_through
from ..evidence.findings import Finding, memories_in, with_findings
from ..given.through import with_functions
from .found import Found

__all__ = ["through_functions"]


def through_functions(found: Found) -> Found | None:
    """Return the records with inputs that act through the functions that were found.

    A low-pass of a function of steps is another signal than the function of the low-pass, and in
    between those effects seem to depend on more. All findings are forgotten then.

    Parameters
    ----------
    found : Found
        What was found so far.

    Returns
    -------
    Found or None
        None unless a function of an input is found that the declared model does not have, and where
        an input has a hidden state, such as a lag: what comes first is not known then.
    """
    acting = _acting(found)
    through = acting[0].through
    if len(through) == len(found.records[0].through):
        return None
    wide = [acting_through(record, through) for record in found.wide_records]
    return found.with_records(acting, wide).without_findings()


def _acting(found: Found) -> Sequence[Record]:
    """Return the records with inputs that act through functions among the findings."""
    acting, taken = found.records, list[Finding]()
    if any(memory.has_state for memory in memories_in(found.findings)):
        return acting
    for finding in found.findings:
        design = with_findings(found.declared, [*taken, finding])
        tried = with_functions(design, found.records)
        if len(tried[0].through) > len(acting[0].through):
            acting, taken = tried, [*taken, finding]
    return acting
