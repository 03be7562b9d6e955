"""Declared terms whose coefficient changes with a measured variable, or with time.

A fan cools better the faster it turns, a spring softens as it warms up, a tank grows lighter as it
runs out.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from itertools import product

from ...terms import Call, Sum, constant, mul, power, sub, variable
from ..given.design import Design
from ..given.ranges import Ranges
from .angles import angles_of
from .candidate import OFFSET, Candidate, CandidateMaker, Shape, bare
from .names import COUPLING, DRIFT, FORCING, INPUT_GAIN, NONLINEAR_DAMPING

LENGTHS = (1.3, 2.0, 3.2, 5.0)  # of hyperbolas, over the largest magnitude of the variable
POWERS = (1, 2)  # of hyperbolas: a belt or a string, a magnet
LENGTH_REACH = 0.25  # in the log of a length: the smallest of them stays beyond the range, no pole


def varying(effect: CandidateMaker, design: Design) -> Iterator[Candidate]:
    """Yield each declared term times a state or an input; squares have names of their own.

    Angles are left out: a change with an angle is periodic, and not in proportion to it.
    """
    acting = set(range(design.time)) - angles_of(design)
    for part in parts_of(design, effect.state):
        for other in map(variable, sorted(acting)):
            both = part.variables | other.variables
            in_time = design.time in both
            name = _name_in_time(part) if in_time else _name_of(both, design, effect.state)
            if other != part and name:
                yield effect(name, mul(other, part), parents=(OFFSET, part), never_paired=True)


def hyperbolas(candidate: Candidate, design: Design, ranges: Ranges) -> list[Candidate]:
    """Return hyperbolas in the place of a declared term times another variable.

    The stiffness of a belt goes with 1 / (L - x), the pull of a magnet with 1 / (L - x)^2: in a
    short range they vary in proportion to x, and so the product is found first.

    Parameters
    ----------
    candidate : Candidate
        What was found; the list is empty unless it is such a product. A power of one variable
        is none: a spring that is curved is rather a polynomial.
    design : Design
        The model without it.
    ranges : Ranges
        Ranges of the variables.

    Returns
    -------
    list of Candidate
        With both signs of the length and several lengths, all beyond the range that was measured.
    """
    found = list[Candidate]()
    for part, place in _factored(candidate, design):
        for sign, factor, exponent in product((1, -1), LENGTHS, POWERS):
            length, branch = factor * float(ranges.largest[place]), sign * exponent
            build = partial(_over_distance, part, place, branch)
            shape = Shape((length,), (build,), LENGTH_REACH, ("length",), branch)
            found.append(replace(candidate, terms=shape.terms, shape=shape))
    return found


def parabolas(candidate: Candidate, design: Design) -> list[Candidate]:
    """Return a product with its variable, and with the square of that, each by its own coefficient.

    Parameters
    ----------
    candidate, design
        As in `hyperbolas`.

    Returns
    -------
    list of Candidate
        One for each variable that may be the factor.
    """
    term = candidate.terms[0]
    return [
        replace(candidate, terms=(term, mul(variable(place), term)), shape=None)
        for _, place in _factored(candidate, design)
    ]


def _factored(candidate: Candidate, design: Design) -> list[tuple[Sum, int]]:
    """Return the declared terms and the variables whose product a candidate is."""
    if len(candidate.terms) != 1 or len(candidate.variables) < 2:
        return []
    term = bare(candidate.terms[0])
    pairs = product(parts_of(design, candidate.state), range(design.time))
    return [(part, place) for part, place in pairs if bare(mul(variable(place), part)) == term]


def _over_distance(part: Sum, place: int, branch: int, length: float) -> Sum:
    """Return a term over L - x, or L + x in negative branches, to the power of the branch."""
    x, sign = variable(place), 1.0 if branch > 0 else -1.0
    distance = sub(constant(length), mul(constant(sign), x))
    return mul(part, power(distance, -abs(branch)))


def _name_in_time(part: Sum) -> str:
    """Return the name of a term of the time that changes with another variable as well."""
    waves = any(isinstance(atom, Call) for _, term in part.parts for atom, _ in term.factors)
    return FORCING if waves else DRIFT


def _name_of(acting: frozenset[int], design: Design, state: int) -> str:
    """Return the name of a product of these variables; empty if it is a power of a spring."""
    if any(v >= len(design.states) for v in acting):
        return INPUT_GAIN
    if acting == {design.position_of(state)}:
        return ""
    return NONLINEAR_DAMPING if acting == {state} else COUPLING


def drifts(effect: CandidateMaker, design: Design, t: Sum) -> Iterator[Candidate]:
    """Yield drifts: of the constant, and of the coefficients of terms.

    A drift that was found may get faster, as the pull on a rocket that burns its fuel does.
    """
    yield effect(DRIFT, t, parents=(OFFSET,))
    parts = parts_of(design, effect.state)
    still = [part for part in parts if not part.variables & t.variables]
    for part in still:
        yield effect(DRIFT, mul(t, part), parents=(part,))
    for changing in (t, *(mul(t, part) for part in still)):
        if changing in parts:
            yield effect(DRIFT, mul(t, changing), parents=(changing,))


def parts_of(design: Design, state: int) -> list[Sum]:
    """Return the expressions with coefficients of their own in an equation, except the constant."""
    parts = (column.parts[state] for column in design.columns)
    return [bare(part) for part in parts if part.variables]
