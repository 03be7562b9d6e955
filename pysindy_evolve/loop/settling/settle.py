"""Fit what was found for good, and take back what the final fit does not bear out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...hidden_states.memory import all_with_memories
from ...signals import Record
from ..evidence.findings import Finding, limits_in, memories_in, with_findings
from ..evidence.offers import after_settling
from ..facts.held_delays import is_hold_only
from ..facts.outcome import Outcome
from ..facts.record_differences import offsets_by_record
from ..facts.shared_lines import shared_lines
from ..given.limits import off_limits
from ..memories.fine_tuning import polished
from ..search.found import Found
from .assembly import assembled
from .contest import with_rivals, without_refuted_rivals
from .other_names import renamed
from .random_walks import last_wandering
from .shape_intervals import with_numbers_known
from .transfer import last_untransferred
from .worse_runs import last_worsened
from .zero_in_interval import most_doubtful


def settled(
    found: Found, test: Sequence[Record], rng: np.random.Generator, *, finished: bool
) -> Outcome:
    """Return what a search came to, one effect less as long as one does not stand.

    Parameters
    ----------
    found : Found
        What the search found.
    test : sequence of Record
        Records to judge on, which decide nothing.
    rng : numpy.random.Generator
        Source of all randomness.
    finished : bool
        Whether the search came to its end.

    Returns
    -------
    Outcome
    """
    while True:
        findings = _with_alternatives(found, rng)
        outcome = assembled(found, findings, test, rng, finished=finished)
        if is_hold_only(outcome):
            found = found.with_holds_for_delays().judged(rng)
            continue
        gone = _what_falls(found, findings, outcome)
        if gone is None:
            break
        found = found.without(found.findings[findings.index(gone)]).judged(rng)
    whole = with_findings(found.declared, findings)
    known = with_numbers_known(outcome, findings, whole, found.rules, rng.spawn(1)[0])
    return replace(known, verdict="untraced") if _differs_by_record(known) else known


def _what_falls(found: Found, findings: Sequence[Finding], outcome: Outcome) -> Finding | None:
    """Return the finding to withdraw, if any.

    Its interval holds zero, it differs between the records, a random walk would do as well, or runs
    or derivatives are worse with it.
    """
    whole = with_findings(found.declared, findings)
    gone = most_doubtful(findings, outcome.effects, whole)
    gone = gone or last_untransferred(found.declared, findings, found.corrected_pieces)
    if gone is not None:
        return gone
    before, after, records = outcome.before.model, outcome.after.model, found.records
    if found.runs_tell_more:
        level = found.rules.significance
        gone = last_wandering(findings, outcome.effects, after, records, level)
    return gone or last_worsened(findings, before, after, records)


def _differs_by_record(outcome: Outcome) -> bool:
    """Tell whether a complete model leaves mostly what no fixed term can be."""
    if outcome.verdict != "complete":
        return False
    return any(line.is_most for line in shared_lines(outcome)) or bool(offsets_by_record(outcome))


def _with_alternatives(found: Found, rng: np.random.Generator) -> list[Finding]:
    """Return what was found, in the same order, each with what could stand in its place."""
    findings, design, rules = found.findings, found.declared, found.rules
    acted = found.pieces.of(all_with_memories(found.wide_records, memories_in(findings)))
    acted = after_settling(found.design, off_limits(acted, limits_in(findings)))
    child = rng.spawn(1)[0]
    rivals = with_rivals(design, findings, acted, rules.significance, child, found.grown.terms)
    if found.runs_tell_more and not found.remembers_states:
        rivals = without_refuted_rivals(design, rivals, found.records)
    named = renamed(design, rivals, acted)
    if found.pieces.by_trajectory:
        return named
    whole = after_settling(with_findings(design, named), found.pieces)
    return polished(design, named, found.records, whole, child.spawn(1)[0])
