"""Which effects may be missing from a design, and what stands in it already."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from ...terms import Sum, of_term, variable
from ..given.design import Design
from ..given.ranges import Ranges
from .candidate import OFFSET, Candidate, bare
from .inputs import clipped_input
from .names import (
    ASYMMETRIC_FRICTION,
    COULOMB_FRICTION,
    DEAD_ZONE,
    DRIFT,
    HARMONIC,
    SATURATING,
    SATURATION,
    VALVE,
)
from .vocabulary import of_equation


def candidates(design: Design, ranges: Ranges) -> list[Candidate]:
    """Return the effects that may be missing from a design.

    Parameters
    ----------
    design : Design
        The model so far.
    ranges : Ranges
        Ranges of states, inputs and time. Powers of a variable that keeps its sign pose as an
        offset no more than the variable itself, and need none beside them.

    Returns
    -------
    list of Candidate
        Effects whose terms all stand in the equation already are left out, unless their coefficient
        is known: what is known may be wrong. The known weight of a falling body is left out as
        well, as a free one absorbs a part of whatever is missing, and so are effects that are
        constant, such as the sign of a temperature in kelvin.
    """
    one_signed = {int(v) for v in np.flatnonzero(~ranges.signed)}
    taken = _taken(design, one_signed)
    return [
        _without_offset(candidate, design, one_signed)
        for state in design.open_states
        for candidate in of_equation(design, state, ranges)
        if not all((state, bare(term)) in taken for term in candidate.terms)
        and not (candidate.variables & one_signed and _is_idle(candidate, design, ranges))
    ]


def for_trajectories(offered: Iterable[Candidate]) -> list[Candidate]:
    """Return the candidates that can be told from the rest on short trajectories.

    There second harmonics, saturating rates and flows of valves can take almost any shape, and do
    as well as any cause.
    """
    return [one for one in offered if one.name not in (HARMONIC, SATURATING, VALVE)]


def _is_idle(candidate: Candidate, design: Design, ranges: Ranges) -> bool:
    """Tell whether an effect of a variable that keeps its sign is a constant, or that variable.

    A dead zone about zero is idle where the variable never is near zero. The friction of a body
    that moves one way only is not idle: it has its name.
    """
    if candidate.name == DEAD_ZONE:
        return not candidate.contains_parents  # stops lie in the range
    if candidate.name in (COULOMB_FRICTION, ASYMMETRIC_FRICTION):
        return design.position_of(candidate.state) is None
    if candidate.name != SATURATION or candidate.shape is None or candidate.contains_parents:
        return False
    return candidate.shape.values[0] <= ranges.smallest(clipped_input(candidate))


def _without_offset(candidate: Candidate, design: Design, one_signed: set[int]) -> Candidate:
    """Drop the offset from the parents of an effect of variables that keep their sign.

    Not so in the equation of a velocity: a position that keeps its sign has an arbitrary zero.
    """
    positioned = design.position_of(candidate.state) is not None
    if positioned or not candidate.variables & one_signed or candidate.name == DRIFT:
        return candidate
    return candidate.needing_no_offset()


def _taken(design: Design, one_signed: set[int]) -> set[tuple[int, Sum]]:
    """Return equation and expression of the terms of a design that are not tried again.

    These are fitted terms, and the known weight of a body that moves one way only.
    """
    falling = {
        s for s in design.open_states if s in one_signed and design.position_of(s) is not None
    }
    weights = {(s, term) for s, term in terms_in(design) if term == OFFSET and s in falling}
    return fitted_terms(design) | weights


def fitted_terms(design: Design) -> set[tuple[int, Sum]]:
    """Return equation and expression of all with a free coefficient, without the coefficient."""
    return terms_in(replace(design, fixed=(Sum(()),) * len(design.states)))


def terms_in(design: Design) -> set[tuple[int, Sum]]:
    """Return equation and expression of all that stands in a design, without its coefficient.

    Terms that share a coefficient, such as q and p in k (q - p), are one expression: a spring to
    the ground may be missing beside it.
    """
    found = set()
    for state in range(len(design.states)):
        found |= {(state, of_term(term)) for _, term in design.fixed[state].parts}
        found |= {(state, bare(part)) for part in design.sides_of(state) if part.parts}
    return found


def with_parents(offered: Iterable[Candidate], design: Design) -> list[Candidate]:
    """Return the candidates whose parents all stand in the design."""
    present = terms_in(design)
    return [c for c in offered if all((c.state, parent) in present for parent in c.parents)]


def beside(candidate: Candidate, design: Design) -> Candidate:
    """Return a candidate with those of its parents that stand in a design.

    Free runs have shown that it needs no others; it may have taken their place.
    """
    present = terms_in(design)
    kept = tuple(parent for parent in candidate.parents if (candidate.state, parent) in present)
    return replace(candidate, parents=kept)


def offsets_setting_zeros(found: Iterable[tuple[int, Sum]], n_states: int) -> set[tuple[int, Sum]]:
    """Return the offsets that would set the zeros of states that were added.

    A leak k (p - p0) is found as k p first, whose size hides how much the offset matters.

    Parameters
    ----------
    found : iterable of (int, Sum)
        Equation and expression of what was found.
    n_states : int
        Number of states, the first variables.

    Returns
    -------
    set of (int, Sum)
        An offset for each equation to which a state itself was added.
    """
    straight = {variable(state) for state in range(n_states)}
    return {(equation, OFFSET) for equation, term in found if term in straight}
