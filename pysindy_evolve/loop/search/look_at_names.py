"""The first look: what has a name, and what remembers, one after the other until none passes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from ..evidence.findings import Finding, excluding, memories_in
from ..evidence.offers import after_settling
from ..memories.chains import with_trades_done
from ..memories.memory_search import find_with_memories, resettled
from ..revision.hidden_numbers import filter_like_paths, needed_by_runs, with_numbers
from ..revision.hyperbolas import with_hyperbolas
from ..revision.past_inputs import settled_beginning
from ..revision.revise import exchange, merged, prune
from ..revision.shared_numbers import with_shared_numbers
from .found import Found
from .how_inputs_act import without_holds


def find_named(found: Found, rng: np.random.Generator) -> Iterator[Found]:
    """Add what has a name, or remembers, one after the other until none passes.

    Parameters
    ----------
    found : Found
        What was found so far.
    rng : numpy.random.Generator
        Source of all randomness.

    Yields
    ------
    Found
        After each step, and before what takes long.
    """
    seen: set[object] = set()
    while found.has_room and found.kinds not in seen:
        seen.add(found.kinds)
        known = found
        found, new = _look_once(known, rng)
        if not new:
            break
        found, new = without_holds(found, new)
        if not new:  # it was how the input was recorded, and no memory of the machine
            continue
        found = _with_new(found, new)
        if not memories_in(new):
            if not _relaxes(found, known):
                yield found  # growing takes long, and may be interrupted
            found = _or_grown(found, known, new, rng)
        if len(found.findings) <= len(known.findings):
            break  # the memory went again: records that begin otherwise do not ask for it
        found = _if_needed(_exchanged(found), known)
        # A new memory alone was tuned when it was found. All others are tuned before the next look,
        # which would otherwise name their error as an effect.
        has_new_memory = len(memories_in(found.findings)) != len(memories_in(known.findings))
        if len(new) > 1 or not has_new_memory:
            found = _tuned(found)
        yield found
    yield _pruned(found)


def tune_memories(found: Found, rng: np.random.Generator) -> Iterator[Found]:
    """Tune the memories that were found beside all else that was.

    Parameters
    ----------
    found : Found
        What was found so far.
    rng : numpy.random.Generator
        Not used: looks are called alike.

    Yields
    ------
    Found
        Once.
    """
    yield _tuned(found)


def _look_once(found: Found, rng: np.random.Generator) -> tuple[Found, list[Finding]]:
    memories = memories_in(found.findings)
    look = find_with_memories(
        found.declared,
        found.design,
        found.corrected_pieces,
        found.rules,
        rng,
        memories,
        relaxing=found.relaxing and not memories,
        springs=found.relaxing,
    )
    return found.with_rejected(look.rejected), found.numbered(look.found)


def _with_new(found: Found, new: Sequence[Finding]) -> Found:
    """Add findings; those with memories in records that begin where their first rows say."""
    findings = [*found.findings, *new]
    if not memories_in(new):
        return found.with_findings(findings)
    findings = with_trades_done(findings)
    part = after_settling(found.with_findings(findings).design, found.pieces)
    findings, plain, wide = settled_beginning(found.declared, findings, found.records, part)
    return found.with_pasts_of(plain, wide).with_findings(findings)


def _or_grown(
    found: Found, known: Found, new: Sequence[Finding], rng: np.random.Generator
) -> Found:
    """Return new findings beside those known, or what grows in their place if clearly better."""
    # A product may be the first sight of a hyperbola, which must not lose to what looks like one.
    forms = with_hyperbolas(found.declared, found.findings, found.corrected_pieces)
    grown = found.grower.better(known.design, forms[-len(new) :], rng)
    if not grown:
        return found
    step = new[0].step
    numbered = [replace(one, step=step) for one in grown]
    # Should the grown term not stand in the end, what it was better than comes back.
    better = found.with_findings([*known.findings, *numbered])
    return replace(better, outdone=(*found.outdone, *new))


def _exchanged(found: Found) -> Found:
    """Return the findings under the names and with the numbers that fit best by now."""
    declared, part = found.declared, found.corrected_pieces
    findings = exchange(declared, found.findings, part)
    findings = with_hyperbolas(declared, findings, part)
    findings = with_numbers(declared, findings, part)
    return found.with_findings(with_shared_numbers(declared, findings, part))


def _if_needed(found: Found, known: Found) -> Found:
    """Return what was found, unless it relaxes or is a spring and runs do not need it."""
    if not _relaxes(found, known):
        return found
    needed = needed_by_runs(found.declared, found.findings, found.corrected_pieces.records)
    if len(needed) == len(found.findings):
        return found
    return replace(known, relaxing=False, rejected=found.rejected)


def _tuned(found: Found) -> Found:
    if not memories_in(found.findings):
        return found
    part = after_settling(found.design, found.pieces)
    return found.with_findings(resettled(found.findings, found.design, part))


def _pruned(found: Found) -> Found:
    """Drop what later findings made superfluous, and put one effect in the place of two."""
    kept = prune(found.declared, found.findings, found.corrected_pieces)
    outdone = (*found.outdone, *excluding(found.findings, *kept))
    left = found.with_findings(merged(found.declared, kept, found.corrected_pieces))
    return replace(left, outdone=outdone)


def _relaxes(found: Found, known: Found) -> bool:
    """Tell whether a relaxation or a spring came in, which needs more proof than others."""
    now, then = (len(filter_like_paths(side.design)) for side in (found, known))
    return now > then
