"""What free runs say of all that was found, and small terms that nothing else shows."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..effects.names import EVOLVED
from ..free_runs.contenders import Pool
from ..free_runs.judging import model_of
from ..free_runs.one_for_one import exchanged_by_runs
from ..free_runs.one_for_several import one_for_several
from ..free_runs.one_in_two_equations import one_in_two_equations
from ..free_runs.sensor_limits import clipped_sensors
from ..free_runs.shared_tuning import shared_by_runs
from ..free_runs.two_for_one import two_for_one
from ..free_runs.unnamed_terms import find_unnamed
from ..revision.errors_in_inputs import without_errors_in_inputs
from ..revision.hidden_numbers import needed_by_runs, with_numbers_of_runs
from ..revision.noise_in_runs import without_noise_in_runs
from ..revision.revise import exchange, prune
from ..revision.superseded import without_superseded
from ..revision.thinning import thinned
from .found import Found
from .look_at_runs import of_kinds_again


def hold_against_runs(found: Found, rng: np.random.Generator) -> Iterator[Found]:
    """Hold all that was found against free runs, and add what these show besides.

    Parameters
    ----------
    found : Found
        What was found so far.
    rng : numpy.random.Generator
        Source of all randomness.

    Yields
    ------
    Found
        After each step.
    """
    if not found.runs_tell_more:
        return
    steps = (_with_unnamed, _without_superfluous, _held_against_rivals, _without_noise, _clipped)
    for step in steps:
        found = step(found, rng)
        yield found


def _with_unnamed(found: Found, rng: np.random.Generator) -> Found:
    """Add terms without a name, such as products of hidden states, that only runs show."""
    child = rng.spawn(1)[0]
    if found.remembers_states:
        return found
    look = find_unnamed(
        found.declared,
        found.findings,
        found.records,
        found.wide_records,
        found.small_terms(),
        found.rules,
        child,
    )
    more = found.with_rejected(look.rejected).with_findings(look.found)
    return of_kinds_again(more, child) if len(look.found) > len(found.findings) else more


def _without_superfluous(found: Found, rng: np.random.Generator) -> Found:
    """Drop what grown terms made superfluous, once each has the name that is right by now."""
    findings = exchange(found.declared, found.findings, found.corrected_pieces)
    kept = prune(found.declared, findings, found.corrected_pieces)
    if not found.remembers_states:
        kept = without_superseded(found.declared, kept, found.records, found.wide_records)
    left = found.with_findings(kept)
    return left.with_findings(thinned(left.declared, kept, left.corrected_pieces))


def _held_against_rivals(found: Found, rng: np.random.Generator) -> Found:
    """Let each effect hold its place against those that come closest to it."""
    declared, records = found.declared, found.records
    if found.remembers_states:
        acted = found.corrected_pieces.records
        findings = with_numbers_of_runs(declared, found.findings, acted)
        return found.with_findings(needed_by_runs(declared, findings, acted))
    model, part, rules = found.bare_model, found.corrected_pieces, found.rules
    grown = [c for c in found.grown.terms if c.name == EVOLVED]
    findings = shared_by_runs(model, found.findings, records)
    pool = Pool(grown, found.small_terms(), part, rules.notable_gain, found.operators)
    findings = one_for_several(model, findings, pool, records)
    findings = two_for_one(model, findings, records, part, rules)
    findings = one_in_two_equations(model, findings, pool, records, rules)
    findings = exchanged_by_runs(model, findings, pool, records, rules)
    findings = shared_by_runs(model, findings, records)  # what won may have partners
    return found.with_findings(prune(declared, findings, part))


def _without_noise(found: Found, rng: np.random.Generator) -> Found:
    """Drop what errors in the readings of inputs, or their noise in runs, explain as well."""
    child = rng.spawn(1)[0]
    declared, part = found.declared, found.corrected_pieces
    findings = without_errors_in_inputs(declared, found.findings, found.wide_records, part, child)
    if not found.remembers_states:
        findings = without_noise_in_runs(declared, findings, found.records, child)
    return found.with_findings(prune(declared, findings, part))


def _clipped(found: Found, rng: np.random.Generator) -> Found:
    """Add the ends of the ranges of sensors, at which only the readings stop."""
    if not found.has_room:
        return found
    model = model_of(found.declared, found.findings)
    return found.with_findings(
        clipped_sensors(model, found.findings, found.records, found.rules, rng)
    )
