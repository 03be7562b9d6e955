"""Inputs that turn out to act otherwise than they were filtered: held, or through functions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from ...signals import Record
from ...signals.zero_order_hold import HALF_SAMPLE, acting_through, hold
from ..evidence.findings import Finding, MemoryFinding, excluding, memories_in, with_findings
from ..evidence.offers import after_settling
from ..given.held import held_where_it_may_be
from ..given.input_functions import with_functions
from ..memories.chains import Traded
from ..memories.hold_or_memory import (
    free_to_be_held,
    hold_beside_another,
    hold_replaces,
    holds_alone,
    in_pieces,
    is_late_like_hold,
    memory_beside_hold,
    smooth_inputs,
)
from .found import Found


def with_holds(found: Found) -> Found | None:
    """Return the records with inputs taken as held, where they are; all findings are forgotten.

    Parameters
    ----------
    found : Found
        What was found so far.

    Returns
    -------
    Found or None
        None where no further input is held.
    """
    if found.declared.algebraic:
        return None
    late = holds_alone(found.design, found.corrected_pieces) or _hidden_holds(found)
    if late:
        return found.with_held(late, held_where_it_may_be).without_findings()
    late = _holds_beside_others(found)
    return found.with_held(late, hold).without_findings() if late else None


def without_holds(found: Found, new: list[Finding]) -> tuple[Found, list[Finding]]:
    """Take inputs as held where that does as well as a memory.

    Parameters
    ----------
    found : Found
        What was found before.
    new : list of Finding
        What a look found.

    Returns
    -------
    tuple of (Found, list of Finding)
        What was found before, on records taken as held, and what remains of the new findings:
        nothing where inputs are taken as held instead, so that all has to be looked at again.
    """
    left = []
    for finding in new:
        if isinstance(finding, MemoryFinding) and not isinstance(finding.memory, Traded):
            late, memory = memory_beside_hold(finding.memory, found.design, found.corrected_pieces)
            if late > 0.0:
                found = found.with_held({finding.memory.column: late}, held_where_it_may_be)
            if memory is None:
                return found, []
            finding = replace(finding, memory=memory)
        left.append(finding)
    return found, left


def _hidden_holds(found: Found) -> dict[int, float]:
    """Return holds that show beside another effect than one that was found, or one more."""
    columns = free_to_be_held(found.corrected_pieces.records)
    if not columns:
        return {}
    with_terms = [finding for finding in found.findings if finding.columns]
    sets = [found.findings, *(excluding(found.findings, one) for one in with_terms)]
    designs = [with_findings(found.declared, findings) for findings in sets]
    part, late = in_pieces(found.corrected_pieces), {}
    for column in columns:
        held_pieces = after_settling(
            found.design, found.pieces_with(found.findings, {column: HALF_SAMPLE})
        )
        held = in_pieces(held_pieces)
        if any(hold_beside_another(column, design, part, held) for design in designs):
            late[column] = HALF_SAMPLE
    return late


def _holds_beside_others(found: Found) -> dict[int, float]:
    """Return holds of smooth inputs that do as well as an effect, where another input is held.

    One computer mostly sets all inputs. Whether a smooth one is held does not show in its samples,
    and in the equations half a sample may look like an offset. A hold has no number to tune, so it
    seldom does as well by chance. What the user said about holds is not doubted.
    """
    records, memories = found.records, memories_in(found.findings)
    late = {one.column for one in memories if is_late_like_hold(one, records)}
    if found.holds_are_told or not late | set(found.held):
        return {}
    free = smooth_inputs(records) - {one.column for one in memories}
    part = in_pieces(found.corrected_pieces)
    for finding in (one for one in found.findings if one.columns):
        design = with_findings(found.declared, excluding(found.findings, finding))
        holds = [k for k in sorted(free) if hold_replaces(finding.candidate, k, design, part)]
        if holds:
            return dict.fromkeys(holds, HALF_SAMPLE)
    return {}


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
