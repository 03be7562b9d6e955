"""Terms without a name, which grow where no name explains what is left."""

from __future__ import annotations

from ..evidence.structure import may_have_structure, structure_chance
from ..growth.short_records import find_small, is_better
from .look_at_names import find_named
from .state import Search

__all__ = ["grow_terms"]

N_SEARCHES = 5  # for grown terms, where they are the only hope: one search may miss them
LIKELY = 0.2  # chance that the residual has no structure, up to which there is such a hope


def grow_terms(search: Search) -> None:
    """Add terms without a name until none passes.

    Parameters
    ----------
    search : Search
        What was found so far; what grows is added.
    """
    if search.corrected_pieces.by_trajectory:
        _grow_by_trajectory(search)
        return
    n_searches = 1 if search.findings else _n_searches(search)
    while search.has_room and _may_lack_more(search):
        found = search.grower.find(search.design, n_searches)
        if not found:
            break
        search.findings = [*search.findings, *search.numbered(found)]


def _may_lack_more(search: Search) -> bool:
    # Growing takes longest, and beside what was found finds nothing where a generic model does not.
    return not search.findings or may_have_structure(search.design, search.grower.seen)


def _n_searches(search: Search) -> int:
    # Not on the pieces that grown terms are tested on: their number would depend on those.
    chance = structure_chance(search.declared, search.grower.seen, search.rules, search.rng)
    return N_SEARCHES if chance <= LIKELY else 1


def _grow_by_trajectory(search: Search) -> None:
    """Let a small term come in where no name did, or where it does better than all of them."""
    if not search.operators or search.rules.max_effects == 0:
        return
    declared, part = search.declared, search.corrected_pieces
    found = find_small(declared, part, search.rules, search.operators, search.rng)
    if found and is_better(declared, found, search.findings, part):
        search.findings = []
        search.findings = search.numbered(found)
        find_named(search)
