"""Hidden states that follow a measured one: a relaxation, or a mass that swings behind it."""

from __future__ import annotations

from collections.abc import Sequence

from ...hidden_states.flexible_mode import FLEXIBLE_MODE
from ...hidden_states.path_states import source_of
from ...hidden_states.relaxing import RELAXING
from ...signals import Record
from ...terms import Call, variable
from ..given.design import Design
from .candidate import Candidate
from .flexible_modes import flexible_ways, within_band
from .relaxation import relaxed_ways, within_reach


def followers_for(design: Design, records: Sequence[Record]) -> list[Candidate]:
    """Return the followers of states that a design may lack.

    Parameters
    ----------
    design : Design
        The model so far.
    records : sequence of Record
        Training records.

    Returns
    -------
    list of Candidate
        Relaxations of a position, or of a state of the first order; in an algebraic target, of any
        input. And masses that swing behind a position.
    """
    longest, n = max(records, key=len), len(design.states)
    taken = {source_of(path) for path in followers_of(design)}
    found = []
    for state in design.open_states:
        position = design.position_of(state)
        sources = [state if position is None else position]
        if design.algebraic:
            sources = list(range(n, n + len(design.inputs)))
        for source in (s for s in sources if variable(s) not in taken):
            found += relaxed_ways(state, source, longest, passive=not design.algebraic)
            if source == position:
                found += flexible_ways(state, source, longest)
    return found


def followers_of(design: Design) -> list[Call]:
    """Return the followers in a design: hidden states whose start is unknown."""
    return [path for path in design.paths if path.operator in (RELAXING, FLEXIBLE_MODE)]


def is_sound(path: Call, record: Record) -> bool:
    """Tell whether a record can tell the relaxation time, or the frequency, of a follower."""
    if path.operator == RELAXING:
        return within_reach(path, record)
    return path.operator != FLEXIBLE_MODE or within_band(path, record)
