"""What only free runs show, and what they say of all that was found."""

from __future__ import annotations

import numpy as np

from ...hidden_states.memory import preceded
from ..effects.names import EVOLVED
from ..evidence.findings import memories_in
from ..evidence.offers import awaited
from ..free_runs.comparison import held_against
from ..free_runs.contenders import Pool
from ..free_runs.judging import model_of
from ..free_runs.named_effects import find_by_runs
from ..free_runs.one_for_several import one_for_several
from ..free_runs.sensor_limits import clipped_sensors
from ..free_runs.shared_tuning import numbers_by_runs, shared_by_runs
from ..free_runs.two_for_one import two_for_one
from ..free_runs.unnamed import find_unnamed
from ..memories.chains import untraded
from ..memories.find import of_kinds_again
from ..revision.errors_in_inputs import without_errors_in_inputs
from ..revision.hidden_numbers import needed_by_runs, with_numbers_of_runs
from ..revision.noise_in_runs import without_noise_in_runs
from ..revision.revise import exchange, merged, prune
from ..revision.superseded import without_outlived
from ..revision.thinning import thinned
from .holding import without_holds
from .state import Search

__all__ = ["find_in_runs", "hold_against_runs"]


def find_in_runs(search: Search) -> None:
    """Add what has a name, or remembers, and shows in nothing but free runs.

    Parameters
    ----------
    search : Search
        What was found so far; what this look finds is added.
    """
    child = search.rng.spawn(1)[0]
    if search.remembers_states:
        return
    tuned = numbers_by_runs(search.bare_model, search.findings, search.records)
    search.findings = merged(search.declared, tuned, search.corrected_pieces)
    look, pasts = find_by_runs(
        search.declared, search.findings, search.records, search.wide_records, search.rules, child
    )
    search.rejected = look.rejected or search.rejected
    known, more = search.findings, list(look.found[len(search.findings) :])
    if more:
        new = without_holds(search, more)
        if not new:  # it was how the input was recorded
            find_in_runs(search)
            return
        search.findings = untraded([*known, *new])
        if pasts:
            search.records = [*map(preceded, search.records, pasts)]
            search.pieces = search.pieces.begun([*map(preceded, search.wide_records, pasts)])
        search.look_through(search.findings)
        _ask_kinds_again(search, child)


def hold_against_runs(search: Search) -> None:
    """Hold all that was found against free runs, and add what these show besides.

    Parameters
    ----------
    search : Search
        What was found so far.
    """
    _find_unnamed(search)
    _drop_superfluous(search)
    _hold_against_rivals(search)
    _doubt_inputs(search)
    _find_clipped_sensors(search)


def _ask_kinds_again(search: Search, rng: np.random.Generator) -> None:
    """Ask of what kind the memories are that were found before what runs showed."""
    before, part = memories_in(search.findings), awaited(search.design, search.pieces)
    level = search.rules.significance
    search.findings = of_kinds_again(search.findings, search.design, part, level, rng)
    if memories_in(search.findings) != before:
        search.look_through(search.findings)


def _find_unnamed(search: Search) -> None:
    child = search.rng.spawn(1)[0]
    if search.remembers_states:
        return
    look = find_unnamed(
        search.declared,
        search.findings,
        search.records,
        search.wide_records,
        search.small_terms(),
        search.rules,
        child,
    )
    search.rejected, known = look.rejected or search.rejected, search.findings
    search.findings = list(look.found)
    if len(search.findings) > len(known):
        _ask_kinds_again(search, child)


def _drop_superfluous(search: Search) -> None:
    """Drop what grown terms made superfluous, once each has the name that is right by now."""
    found = exchange(search.declared, search.findings, search.corrected_pieces)
    kept = prune(search.declared, found, search.corrected_pieces)
    if not search.remembers_states:
        kept = without_outlived(search.declared, kept, search.records, search.wide_records)
    if len(memories_in(kept)) < len(memories_in(search.findings)):
        search.look_through(kept)
    search.findings = thinned(search.declared, kept, search.corrected_pieces)


def _hold_against_rivals(search: Search) -> None:
    if search.remembers_states:
        found = with_numbers_of_runs(
            search.declared, search.findings, search.corrected_pieces.records
        )
        search.findings = needed_by_runs(search.declared, found, search.corrected_pieces.records)
        return
    model = search.bare_model
    grown = [c for c in search.grower.grown if c.name == EVOLVED]
    small = search.small_terms()
    found = shared_by_runs(model, search.findings, search.records)
    pool = Pool(grown, small, search.corrected_pieces, search.rules.notable_gain)
    found = one_for_several(model, found, pool, search.records)
    found = two_for_one(model, found, search.records, search.corrected_pieces, search.rules)
    kept = held_against(model, found, pool, search.records, search.rules)
    kept = shared_by_runs(model, kept, search.records)  # what won may have partners
    search.findings = prune(search.declared, kept, search.corrected_pieces)


def _doubt_inputs(search: Search) -> None:
    child = search.rng.spawn(1)[0]
    found = without_errors_in_inputs(
        search.declared, search.findings, search.wide_records, search.corrected_pieces, child
    )
    if not search.remembers_states:
        found = without_noise_in_runs(search.declared, found, search.records, child)
    search.findings = prune(search.declared, found, search.corrected_pieces)


def _find_clipped_sensors(search: Search) -> None:
    if search.has_room:
        model = model_of(search.declared, search.findings)
        search.findings = clipped_sensors(
            model, search.findings, search.records, search.rules, search.rng
        )
