"""Terms without a name, which grow where no name explains what is left."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..evidence.structure import may_have_structure, structure_chance
from ..growth.short_records import find_small, is_better
from .found import Found
from .look_at_names import find_named

N_SEARCHES = 5  # for grown terms, where they are the only hope: one search may miss them
MAX_CHANCE = 0.2  # chance that the residual has no structure, up to which there is such a hope


def grow_terms(found: Found, rng: np.random.Generator) -> Iterator[Found]:
    """Add terms without a name until none passes.

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
    if found.pieces.by_trajectory:
        yield from _grow_by_trajectory(found, rng)
        return
    n_searches = 1 if found.findings else _n_searches(found, rng)
    while found.has_room and _may_lack_more(found):
        new = found.grower.find(found.design, rng, n_searches)
        if not new:
            break
        found = found.with_findings([*found.findings, *found.numbered(new)])
        yield found


def _may_lack_more(found: Found) -> bool:
    # Growing takes longest, and beside what was found finds nothing where a generic model does not.
    return not found.findings or may_have_structure(found.design, found.grower.seen)


def _n_searches(found: Found, rng: np.random.Generator) -> int:
    # Not on the pieces that grown terms are tested on: their number would depend on those.
    chance = structure_chance(found.declared, found.grower.seen, found.rules, rng)
    return N_SEARCHES if chance <= MAX_CHANCE else 1


def _grow_by_trajectory(found: Found, rng: np.random.Generator) -> Iterator[Found]:
    """Let a small term come in where no name did, or where it does better than all of them."""
    if not found.operators or found.rules.max_effects == 0:
        return
    declared, part = found.declared, found.corrected_pieces
    new = find_small(declared, part, found.rules, found.operators, rng)
    if new and is_better(declared, new, found.findings, part):
        bare = found.with_findings([])
        yield from find_named(bare.with_findings(bare.numbered(new)), rng)
