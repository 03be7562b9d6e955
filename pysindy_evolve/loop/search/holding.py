"""Inputs that turn out to be held between their samples, which changes all that was found."""

from __future__ import annotations

from dataclasses import replace

from ...signals.zero_order_hold import HALF
from ..evidence.findings import Finding, MemoryFinding, excluding, with_findings
from ..evidence.offers import awaited
from ..given.held import held_where_it_may_be
from ..memories.chains import Traded
from ..memories.hold_or_memory import (
    free_to_be_held,
    hold_beside_another,
    holds_alone,
    in_pieces,
    memory_beside_hold,
)
from .state import Search

__all__ = ["take_holds", "without_holds"]


def take_holds(search: Search) -> bool:
    """Take inputs as held that are, and tell whether any is.

    Parameters
    ----------
    search : Search
        Has found what it could until now.

    Returns
    -------
    bool
    """
    if search.declared.algebraic:
        return False
    late = holds_alone(search.design, search.corrected_pieces) or _hidden_holds(search)
    if late:
        search.take_as_held(late, held_where_it_may_be)
    return bool(late)


def without_holds(search: Search, found: list[Finding]) -> list[Finding]:
    """Take inputs as held where that does as well as a memory, and return what is left.

    Parameters
    ----------
    search : Search
        Its records are taken as held.
    found : list of Finding
        What a look found.

    Returns
    -------
    list of Finding
        Empty where inputs are taken as held instead, so that all has to be looked at again.
    """
    left = []
    for finding in found:
        if isinstance(finding, MemoryFinding) and not isinstance(finding.memory, Traded):
            late, memory = memory_beside_hold(
                finding.memory, search.design, search.corrected_pieces
            )
            if late > 0.0:
                search.take_as_held({finding.memory.column: late}, held_where_it_may_be)
            if memory is None:
                return []
            finding = replace(finding, memory=memory)
        left.append(finding)
    return left


def _hidden_holds(search: Search) -> dict[int, float]:
    """Return holds that show beside another effect than one that was found, or one more."""
    columns = free_to_be_held(search.corrected_pieces.records)
    if not columns:
        return {}
    found = [finding for finding in search.findings if finding.columns]
    left = [search.findings, *(excluding(search.findings, one) for one in found)]
    designs = [with_findings(search.declared, findings) for findings in left]
    part, late = in_pieces(search.corrected_pieces), {}
    for column in columns:
        part_held = awaited(search.design, search.pieces_with(search.findings, {column: HALF}))
        held = in_pieces(part_held)
        if any(hold_beside_another(column, design, part, held) for design in designs):
            late[column] = HALF
    return late
