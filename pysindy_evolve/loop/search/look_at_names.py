"""The first look: what has a name, and what remembers, one after the other until none passes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from ...hidden_states.memory import Memory
from ..evidence.findings import Finding, excluding, memories_in, with_findings
from ..evidence.offers import awaited
from ..memories.chains import untraded
from ..memories.find import find_with_memories, resettled
from ..revision.beginnings import settled_beginning
from ..revision.hidden_numbers import needed_by_runs, smooth_in, with_numbers
from ..revision.revise import exchange, merged, prune
from ..revision.sharing import with_shared_numbers
from .holding import without_holds
from .state import Search

__all__ = ["find_named", "tune_memories"]


def find_named(search: Search) -> None:
    """Add what has a name, or remembers, one after the other until none passes.

    Parameters
    ----------
    search : Search
        What was found so far; what this look finds is added.
    """
    while search.has_room:
        before, memories = search.findings, memories_in(search.findings)
        new = search.numbered(_look_once(search, memories))
        if not new:
            break
        if memories_in(new):
            kept = without_holds(search, new)
            if not kept:  # it was how the input was recorded, and no memory of the machine
                continue
            found = _begun(search, untraded([*before, *kept]))
        else:
            found = _or_grown(search, before, new)
        if len(found) <= len(before):  # a memory goes where records begin otherwise
            search.findings = found
            break
        _take(search, found, before)
        if len(new) > 1 or len(memories_in(search.findings)) == len(memories):
            tune_memories(search)  # or what is wrong with one would be named as another one
    kept = prune(search.declared, search.findings, search.corrected_pieces)
    search.outdone = excluding(search.findings, *kept)
    search.findings = merged(search.declared, kept, search.corrected_pieces)


def tune_memories(search: Search) -> None:
    """Tune the memories that were found beside all else that was.

    Parameters
    ----------
    search : Search
        What was found so far.
    """
    if memories_in(search.findings):
        part = awaited(search.design, search.pieces)
        search.findings = resettled(search.findings, search.design, part)
        search.look_through(search.findings)


def _look_once(search: Search, memories: Sequence[Memory]) -> Sequence[Finding]:
    look = find_with_memories(
        search.declared,
        search.design,
        search.corrected_pieces,
        search.rules,
        search.rng,
        memories,
        relaxing=search.relaxing and not memories,
        springs=search.relaxing,
    )
    search.rejected = look.rejected or search.rejected
    return look.found


def _or_grown(search: Search, before: list[Finding], new: list[Finding]) -> list[Finding]:
    """Return all findings with new ones, or with what grows and does clearly better."""
    both, design = [*before, *new], search.design
    # Growing takes long, and may be interrupted.
    search.findings = before if _relaxes(search, both, before) else both
    search.wait(both)
    grown = search.grower.better(design, new)
    return [*before, *(replace(finding, step=new[0].step) for finding in grown or new)]


def _begun(search: Search, findings: list[Finding]) -> list[Finding]:
    """Look through the records as memories make them, begun where their first rows say."""
    part = awaited(with_findings(search.declared, findings), search.pieces)
    begun = settled_beginning(search.declared, findings, search.records, part)
    search.records, search.pieces = begun.plain, search.pieces.begun(begun.wide)
    search.look_through(begun.findings)
    return list(begun.findings)


def _take(search: Search, found: list[Finding], before: list[Finding]) -> None:
    """Keep findings, earlier ones under the names and numbers that they have by now."""
    found = exchange(search.declared, found, search.corrected_pieces)
    found = with_numbers(search.declared, found, search.corrected_pieces)
    search.findings = with_shared_numbers(search.declared, found, search.corrected_pieces)
    _take_back(search, before)


def _take_back(search: Search, before: list[Finding]) -> None:
    """Take back a relaxation or a spring that runs do not need, and what came with it."""
    if _relaxes(search, search.findings, before):
        needed = needed_by_runs(search.declared, search.findings, search.corrected_pieces.records)
        if len(needed) < len(search.findings):
            search.findings, search.relaxing = before, False
            search.look_through(before)


def _relaxes(search: Search, findings: list[Finding], before: list[Finding]) -> bool:
    """Tell whether a relaxation or a spring came in, which needs more proof than others."""
    sides = (with_findings(search.declared, those) for those in (findings, before))
    now, known = (len(smooth_in(side)) for side in sides)
    return now > known
