"""What only free runs show: named effects, and what remembers."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..evidence.offers import after_settling
from ..free_runs.named_effects import find_by_runs
from ..free_runs.shared_tuning import numbers_by_runs
from ..memories.chains import with_trades_done
from ..memories.memory_search import with_kinds_rechosen
from ..revision.revise import merged
from .found import Found
from .how_inputs_act import without_holds


def find_in_runs(found: Found, rng: np.random.Generator) -> Iterator[Found]:
    """Add what has a name, or remembers, and shows in nothing but free runs.

    Parameters
    ----------
    found : Found
        What was found so far.
    rng : numpy.random.Generator
        Source of all randomness.

    Yields
    ------
    Found
        In the end.
    """
    if not found.runs_tell_more:
        return
    child = rng.spawn(1)[0]
    if found.remembers_states:
        return
    tuned = numbers_by_runs(found.bare_model, found.findings, found.records)
    found = found.with_findings(merged(found.declared, tuned, found.corrected_pieces))
    look, pasts = find_by_runs(
        found.declared, found.findings, found.records, found.wide_records, found.rules, child
    )
    found = found.with_rejected(look.rejected)
    more = list(look.found[len(found.findings) :])
    if more:
        found, new = without_holds(found, more)
        if not new:  # it was how the input was recorded
            yield from find_in_runs(found, rng)
            return
        findings = with_trades_done([*found.findings, *new])
        found = (found.with_past_inputs(pasts) if pasts else found).with_findings(findings)
        found = of_kinds_again(found, child)
    yield found


def of_kinds_again(found: Found, rng: np.random.Generator) -> Found:
    """Ask of what kind the memories are that were found before what runs showed."""
    part = after_settling(found.design, found.pieces)
    level = found.rules.significance
    return found.with_findings(with_kinds_rechosen(found.findings, found.design, part, level, rng))
