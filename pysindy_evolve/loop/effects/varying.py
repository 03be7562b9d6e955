"""Declared terms whose coefficient changes with a measured variable, or with time.

A fan cools better the faster it turns, prey is caught less the more of it there is, a spring
softens as it warms up, a tank grows lighter as it runs out, a valve lets through the less the
higher the pressure behind it is.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from itertools import combinations, product

import numpy as np

from ...operators import BUILTIN
from ...terms import (
    Atom,
    Call,
    Sum,
    add,
    as_product,
    as_sum,
    call,
    constant,
    div,
    mul,
    power,
    sub,
    variable,
)
from ..given.design import Design
from .angles import angles_of
from .candidate import OFFSET, Candidate, CandidateMaker, Shape, bare
from .names import COUPLING, DRIFT, FORCING, INPUT_GAIN, NONLINEAR_DAMPING, SATURATING, VALVE

__all__ = ["drifts", "hyperbolas", "parabolas", "parts_of", "saturating", "throttled", "varying"]

HALVES = (0.3, 1.0, 3.0)  # levels at which a rate is half of its largest, over the largest level
LENGTHS = (1.3, 2.0, 3.2, 5.0)  # of hyperbolas, over the largest magnitude of the variable
POWERS = (1, 2)  # of hyperbolas: a belt or a string, a magnet
LENGTH_REACH = 0.25  # in the log of a length: the smallest of them stays beyond the range, no pole
SUPPLIES = (1.2, 2.0, 4.0)  # pressures of a supply, over the largest pressure of the record


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


def hyperbolas(candidate: Candidate, design: Design, scales: np.ndarray) -> list[Candidate]:
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
    scales : ndarray of shape (n_variables,)
        Largest magnitude of each variable.

    Returns
    -------
    list of Candidate
        With both signs of the length and several lengths, all beyond the range that was measured.
    """
    found = list[Candidate]()
    for part, place in _factored(candidate, design):
        for sign, factor, exponent in product((1, -1), LENGTHS, POWERS):
            length, branch = factor * float(scales[place]), sign * exponent
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


def saturating(
    effect: CandidateMaker, design: Design, scales: np.ndarray, middle: np.ndarray
) -> Iterator[Candidate]:
    """Yield declared products that saturate with a level x of theirs, which stays above zero.

    - The rate over K + x: a predator is sated, a reaction inhibited, the gain of a laser
      compressed. Beside it the declared rate may vanish.
    - The rate times x / (K^2 + x^2), which begins with the square of x: prey hides.
    - A rate that saturates already, with one more level in its denominator: predators are sated,
      and also keep each other from eating.
    - A rate that saturates with its level, with the square of that: too much of it inhibits.
    - The rate over K x + y: what counts is how much there is for each.

    The same rate may stand in two equations, as predators grow by what they eat.
    """
    if design.position_of(effect.state) is not None:
        return
    for part in parts_of(design, effect.state):
        acting = sorted(part.variables - {design.time}) if len(part.variables) > 1 else []
        levels = [level for level in acting if 2.0 * middle[level] > scales[level]]
        for level in levels:
            crowded = (_crowded,) if _saturates(part, level) else ()
            inhibited = (_inhibited,) if _saturates(part, level, by_itself=True) else ()
            for build in (_over, _hiding, *crowded, *inhibited):
                yield from _sated(effect, partial(build, part, level), level, float(scales[level]))
        for level, other in combinations(levels, 2):
            ratio = float(scales[other] / scales[level])
            yield from _sated(effect, partial(_for_each, part, level, other), level, ratio)


def _sated(
    effect: CandidateMaker, build: Callable[[float], Sum], level: int, size: float
) -> Iterator[Candidate]:
    """Yield a rate with several half-saturation constants."""
    for share in HALVES:
        half = Shape((share * size,), (build,), meanings=("half-saturation",))
        candidate = effect(SATURATING, shape=half, never_paired=True)
        yield replace(candidate, acts_at=((level,), candidate.terms))


def throttled(
    effect: CandidateMaker, design: Design, scales: np.ndarray, middle: np.ndarray
) -> Iterator[Candidate]:
    """Yield declared inputs as openings of a valve: flow goes with the root of a pressure.

    That is the supply less the pressure of the load, or plus it where the valve is reversed. A
    pressure that stays above zero is that of a chamber: the supply less this pressure drives the
    flow in, and the pressure itself drives it out.
    """
    state, inputs = effect.state, range(len(design.states), design.time)
    if design.position_of(state) is not None or scales[state] == 0.0:
        return
    is_chamber = 2.0 * middle[state] > scales[state]
    build = _of_chamber if is_chamber else _of_load
    acting = parts_of(design, state)
    for opening in (u for u in map(variable, inputs) if u in acting):
        for share in SUPPLIES:
            supply = Shape(
                (share * float(scales[state]),),
                (partial(build, opening, variable(state)),),
                meanings=("supply pressure",),
            )
            yield effect(VALVE, shape=supply, never_paired=True)


def _of_load(opening: Sum, pressure: Sum, supply: float) -> Sum:
    """Return an opening times the root of the supply less the pressure that it works against."""
    against = mul(call(BUILTIN["sgn"], opening), pressure)
    return mul(opening, _root(sub(constant(supply), against)))


def _of_chamber(opening: Sum, pressure: Sum, supply: float) -> Sum:
    """Return an opening times the root of what drives flow into a chamber, or out of it."""
    half = constant(0.5 * supply)
    inward = mul(call(BUILTIN["sgn"], opening), sub(half, pressure))
    return mul(opening, _root(add(half, inward)))


def _root(drop: Sum) -> Sum:
    """Return the root of a magnitude, as noise may lift a pressure above that of the supply."""
    return call(BUILTIN["sqrt"], call(BUILTIN["abs"], drop))


def _over(part: Sum, level: int, half: float) -> Sum:
    """Return a rate over a constant and a level."""
    return div(part, add(constant(half), variable(level)))


def _hiding(part: Sum, level: int, half: float) -> Sum:
    """Return a rate that begins with the square of a level, as of prey in cover.

    Type III of Holling, Mem. Entomol. Soc. Can. 97 (1965), DOI 10.4039/entm9745fv.
    """
    x = variable(level)
    return div(mul(part, x), add(constant(half**2), power(x, 2)))


def _for_each(part: Sum, level: int, other: int, half: float) -> Sum:
    """Return a rate over K times a level plus another one: over how much there is for each."""
    return div(part, add(mul(constant(half), variable(level)), variable(other)))


def _saturates(part: Sum, level: int, *, by_itself: bool = False) -> bool:
    """Tell whether a rate has a denominator with a constant, and this level in it or not."""
    return any(_below(one, level, by_itself) is not None for one in as_product(part).factors)


def _below(factor: tuple[Atom, int], level: int, inside: bool) -> Sum | None:
    """Return the denominator of a factor over its constant, if the level is inside or not."""
    atom, exponent = factor
    if not isinstance(atom, Sum) or exponent != -1 or (level in atom.variables) != inside:
        return None
    still = sum(number for number, term in atom.parts if not term.variables)
    return div(atom, constant(still)) if still else None


def _crowded(part: Sum, level: int, half: float) -> Sum:
    """Return a rate with one more level in its denominator, added like the constant."""
    x = variable(level)
    return _with_below(part, level, False, lambda below: add(mul(constant(half), below), x))


def _inhibited(part: Sum, level: int, half: float) -> Sum:
    """Return a rate with the square of its own level in its denominator: too much of it inhibits.

    Andrews, Biotechnol. Bioeng. 10 (1968), DOI 10.1002/bit.260100602, after Haldane.
    """
    square = mul(constant(half**-2), power(variable(level), 2))
    return _with_below(part, level, True, lambda below: add(below, square))


def _with_below(part: Sum, level: int, inside: bool, change: Callable[[Sum], Sum]) -> Sum:
    """Return a rate with changed denominators, those with the level inside or the others."""
    changed = constant(1.0)
    for atom, exponent in as_product(part).factors:
        below = _below((atom, exponent), level, inside)
        kept = power(as_sum(atom), exponent)
        changed = mul(changed, kept if below is None else power(change(below), -1))
    return changed


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
