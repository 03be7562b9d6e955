"""What begins at a level of a first-order state: an overflow, a dose that starts to harm.

Such a kink bends as many other terms do, so it has no place among the names. It is held against
what grows, with its level tuned on the same pieces.
"""

from __future__ import annotations

from dataclasses import replace

from ...terms import variable
from ..effects.candidate import Candidate, CandidateMaker
from ..effects.stops import stops
from ..evidence.scoring import sharpened
from ..given.design import Design
from ..given.segments import Segments, ranges

__all__ = ["begun_at_levels"]


def begun_at_levels(design: Design, state: int, part: Segments) -> list[Candidate]:
    """Return the dead zones with one end that explain most of what an equation leaves.

    Parameters
    ----------
    design : Design
        The model so far.
    state : int
        Equation in question. That of a velocity has the stops of its position among the names.
    part : Segments
        Pieces to tune the levels on.

    Returns
    -------
    list of Candidate
        None if the state is a velocity, or where no level explains anything.
    """
    if design.position_of(state) is not None:
        return []
    largest, signed, _, middle = ranges(part.rows)
    offered = stops(CandidateMaker(state), variable(state), largest[state], middle[state])
    # A level is where it is, and needs no offset beside it where the state has a zero of its own.
    grid = list(offered) if signed[state] else [replace(one, parents=()) for one in offered]
    return sharpened(design, part, grid)[len(grid) :]
