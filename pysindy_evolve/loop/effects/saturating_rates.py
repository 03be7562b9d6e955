"""Declared rates that saturate: the more prey there is, the smaller a share of it is caught."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from itertools import combinations

from ...terms import Atom, Sum, add, as_product, as_sum, constant, div, mul, power, variable
from ..given.design import Design
from ..given.ranges import Ranges
from .candidate import Candidate, CandidateMaker, Shape
from .names import SATURATING
from .varying_terms import parts_of

HALVES = (0.3, 1.0, 3.0)  # levels at which a rate is half of its largest, over the largest level


def saturating(effect: CandidateMaker, design: Design, ranges: Ranges) -> Iterator[Candidate]:
    """Yield declared products that saturate with a level x of theirs, which stays above zero.

    - The rate over K + x: a predator is sated, a reaction inhibited, the gain of a laser
      compressed. Beside it the declared rate may vanish. What inhibits may be no factor of it.
    - The rate times x / (K^2 + x^2), which begins with the square of x: prey hides.
    - A rate that saturates already, with one more level in its denominator: predators are sated,
      and also keep each other from eating, or another substance competes for the same enzyme.
    - A rate that saturates with its level, with the square of that: too much of it inhibits.
    - The rate over K x + y: what counts is how much there is for each.

    The same rate may stand in two equations, as predators grow by what they eat.
    """
    if design.position_of(effect.state) is not None:
        return
    largest = ranges.largest
    for part in parts_of(design, effect.state):
        acting = sorted(part.variables - {design.time}) if len(part.variables) > 1 else []
        levels = [level for level in acting if ranges.stays_positive(level)]
        below = _denominators(part)
        for level in levels:
            crowded = (_crowded,) if any(level not in one.variables for one in below) else ()
            inhibited = (_inhibited,) if any(level in one.variables for one in below) else ()
            for build in (_over, _hiding, *crowded, *inhibited):
                yield from _sated(effect, partial(build, part, level), level, float(largest[level]))
        others = sorted(set(range(len(largest))) - part.variables - {design.time})
        inhibiting = others if acting or below else []
        for level in (one for one in inhibiting if ranges.stays_positive(one)):
            for build in (_over, *((_crowded,) if below else ())):
                yield from _sated(effect, partial(build, part, level), level, float(largest[level]))
        for level, other in combinations(levels, 2):
            ratio = float(largest[other] / largest[level])
            yield from _sated(effect, partial(_for_each, part, level, other), level, ratio)


def _sated(
    effect: CandidateMaker, build: partial[Sum], level: int, scale: float
) -> Iterator[Candidate]:
    """Yield a rate with several numbers in its denominator; each form is tuned by itself."""
    form, meanings = list(FORMS).index(build.func), (FORMS[build.func],)
    for share in HALVES:
        half = Shape((share * scale,), (build,), meanings=meanings, branch=form)
        candidate = effect(SATURATING, shape=half, never_paired=True)
        yield replace(candidate, acts_at=((level,), candidate.terms))


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


def _crowded(part: Sum, level: int, half: float) -> Sum:
    """Return a rate with one more level in its denominator, added like the constant."""
    x = variable(level)

    def change(below: Sum) -> Sum | None:
        return None if level in below.variables else add(mul(constant(half), below), x)

    return _with_denominators(part, change)


def _inhibited(part: Sum, level: int, half: float) -> Sum:
    """Return a rate with the square of its own level in its denominator: too much of it inhibits.

    Andrews, Biotechnol. Bioeng. 10 (1968), DOI 10.1002/bit.260100602, after Haldane.
    """
    square = mul(constant(half**-2), power(variable(level), 2))

    def change(below: Sum) -> Sum | None:
        return add(below, square) if level in below.variables else None

    return _with_denominators(part, change)


FORMS = {  # and what the number in each means
    _over: "half-saturation",
    _hiding: "half-saturation",
    _crowded: "inhibition constant",
    _inhibited: "inhibition level",
    _for_each: "factor in the denominator",
}


def _denominators(part: Sum) -> list[Sum]:
    """Return what a rate saturates by: its denominators with a constant, each over that."""
    found = (_below(atom, exponent) for atom, exponent in as_product(part).factors)
    return [below for below in found if below is not None]


def _with_denominators(part: Sum, change: Callable[[Sum], Sum | None]) -> Sum:
    """Return a rate with its denominators changed; those stay for which nothing is returned."""
    changed = constant(1.0)
    for atom, exponent in as_product(part).factors:
        below = _below(atom, exponent)
        other = None if below is None else change(below)
        factor = power(as_sum(atom), exponent) if other is None else power(other, -1)
        changed = mul(changed, factor)
    return changed


def _below(atom: Atom, exponent: int) -> Sum | None:
    """Return the denominator that a factor is, over its constant; None if it is no such one."""
    if not isinstance(atom, Sum) or exponent != -1:
        return None
    still = sum(number for number, term in atom.parts if not term.variables)
    return div(atom, constant(still)) if still else None
