"""The effects that could stand in the place of one that was found: its alternatives."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import reduce
from itertools import accumulate, pairwise

import numpy as np

from ...terms import Call, Sum, add, as_sum, constant, mul, power
from ..effects.candidate import OFFSET, Candidate
from ..effects.hysteresis import rounded_sign
from ..effects.missing import candidates, for_trajectories, standing, with_parents
from ..effects.names import EVOLVED
from ..effects.shaping import with_units
from ..given.design import Design
from ..given.segments import Segments
from .drifting_rivals import leads_over, twin_chance
from .encompassing import chance, explained
from .same_model import hold
from .scoring import columns_of
from .spectral import spectral_grams
from .trace import fold_errors

__all__ = ["Rival", "rivals_of"]

ROUNDED = 0.1  # width of a sign that is rounded off, in sizes of what it is the sign of
# Share of what an effect explains that a rival must explain in its place. Where much is missing,
# anything could hide in the rest, and a test alone refutes nothing.
EXPLAINED = 1.0 / 3.0
FARTHER = 2.0  # times the held-out squares of an effect, from which on a rival is outdone
STEADY = 0.1  # of its mean, that a term varies by if it is a constant
ENOUGH = 3  # names in a row that twins refute; then the search for rivals stops: the rest fit worse
MORE = 2  # nodes that another form of a grown term may have


@dataclass(frozen=True, eq=False)
class Rival:
    """An effect that could have left the same record in another one's place.

    Attributes
    ----------
    candidate : Candidate
        Name, equation and terms.
    p_value : float
        Chance that the other effect gains as much beside it, if this one were the cause.
    """

    candidate: Candidate
    p_value: float

    @property
    def name(self) -> str:
        """Name of the vocabulary."""
        return self.candidate.name


def rivals_of(
    candidate: Candidate,
    design: Design,
    part: Segments,
    level: float,
    rng: np.random.Generator,
    grown: Sequence[Candidate] = (),
) -> tuple[Rival, ...]:
    """Return the effects that could stand in the place of one.

    Parameters
    ----------
    candidate : Candidate
        The effect.
    design : Design
        The whole model without it.
    part : Segments
        Pieces of the training records.
    level : float
        A rival with a smaller p-value is refuted.
    rng : numpy.random.Generator
        Draws the signs.
    grown : sequence of Candidate
        Terms that grew as well; of a grown term they are other forms.

    Returns
    -------
    tuple of Rival
        The best form of each name, the least refuted first; other forms of the effect itself
        count as well.
    """
    known = standing(design)
    proposed = candidates(design, part.ranges)
    if part.by_trajectory:
        proposed = for_trajectories(proposed)
    proposed += [*_rounded(candidate, part), *_grown_forms(candidate, grown)]
    complete = [_with_offset(c, known) for c in proposed]
    able = with_parents(complete, design)
    if OFFSET in candidate.terms:  # one that brings the effect itself does not stand in its place
        able = [c for c in able if c.state != candidate.state or OFFSET not in c.terms]
        able = [c for c in able if not _hardly_varies(c, part)]
    rest = (c for c in dict.fromkeys(able) if _differs(c, candidate, design))
    options = [c for c in rest if not _is_form(c, candidate)]
    if part.by_trajectory:
        return _by_twins(candidate, options, design, part, level, rng)
    everything = [column for c in (candidate, *options) for column in columns_of(c, design)]
    grams = spectral_grams(part, design, [*design.columns, *everything])
    first = len(design.columns)
    base, places = tuple(range(first)), _places(first, (candidate, *options))
    own, *others = places
    ours, *theirs = explained(grams, base, places)
    if ours <= 0.0:  # it explains nothing beside the others any more, and so does anything
        return ()
    best: dict[str, Rival] = {}
    for option, place, squares in zip(options, others, theirs, strict=True):
        if squares < EXPLAINED * ours:
            continue
        p_value = chance(grams, (*base, *place), own, level, rng)
        if p_value > level and _is_outdone(grams, (*base, *place), (*base, *own), part.folds):
            continue
        if p_value > max(level, best[option.name].p_value if option.name in best else 0.0):
            best[option.name] = Rival(option, p_value)
    return tuple(sorted(best.values(), key=lambda rival: -rival.p_value))


def _is_outdone(
    grams: np.ndarray, rival: Sequence[int], own: Sequence[int], folds: np.ndarray
) -> bool:
    """Tell whether a rival predicts held-out pieces much worse than the effect, and most of them.

    The cause would hardly do so by chance. Where a few pieces tell both apart very clearly, and the
    others do not, the scatter over the pieces hides it.
    """
    theirs, ours = (fold_errors(grams, np.array([model]), folds)[0] for model in (rival, own))
    return bool(theirs.sum() > FARTHER * ours.sum() and np.median(theirs / ours) > 1.0)


def _differs(option: Candidate, candidate: Candidate, bare: Design) -> bool:
    """Tell whether an option brings something to the model without both, but not the effect.

    What brings the effect itself, under another sign or name or with something beside it, does not
    stand in its place; nor does what the model holds already.
    """
    brought = columns_of(option, bare)
    with_option = [*bare.columns, *brought]
    return not hold(bare.columns, brought) and not hold(with_option, columns_of(candidate, bare))


def _with_offset(candidate: Candidate, known: set[tuple[int, Sum]]) -> Candidate:
    """Return a candidate that brings the offset it needs, such as a drift, if none stands."""
    if OFFSET not in candidate.parents or (candidate.state, OFFSET) in known:
        return candidate
    others = tuple(parent for parent in candidate.parents if parent != OFFSET)
    shape = candidate.shape
    if shape is not None:
        shape = replace(shape, builds=(_offset, *shape.builds))
    return replace(candidate, terms=(OFFSET, *candidate.terms), parents=others, shape=shape)


def _offset(*numbers: float) -> Sum:
    """Return the offset, whatever the numbers are that the terms beside it are tuned to."""
    return OFFSET


def _by_twins(
    candidate: Candidate,
    options: Sequence[Candidate],
    design: Design,
    part: Segments,
    level: float,
    rng: np.random.Generator,
) -> tuple[Rival, ...]:
    """Return the alternatives of an effect on short trajectories.

    Those of one name that come closest are asked first, and none that comes less close than several
    that were refuted.
    """
    whole = [candidate, *options]
    leads = leads_over(whole, design, part.records)[1:]
    closest: dict[str, Candidate] = {}
    for k in np.argsort(leads, kind="stable"):
        closest.setdefault(options[k].name, options[k])
    found: list[Rival] = []
    n_refuted = 0
    for option in closest.values():
        p_value = twin_chance(option, design, whole, part.records, level, rng)
        if p_value > level:
            found.append(Rival(option, p_value))
        n_refuted = 0 if p_value > level else n_refuted + 1
        if n_refuted == ENOUGH:
            break
    return tuple(sorted(found, key=lambda rival: -rival.p_value))


def _places(first: int, candidates: Sequence[Candidate]) -> list[tuple[int, ...]]:
    """Return the columns of each candidate, one after the other."""
    ends = list(accumulate((len(one.terms) for one in candidates), initial=first))
    return [tuple(range(*pair)) for pair in pairwise(ends)]


def _is_form(one: Candidate, other: Candidate) -> bool:
    """Tell whether two candidates differ in the number of their shape only."""
    shapes = one.shape, other.shape
    return None not in shapes and (one.name, one.state) == (other.name, other.state)


def _hardly_varies(candidate: Candidate, part: Segments) -> bool:
    """Tell whether an effect is a constant by another name, as cos(q) of small angles is."""
    columns = [term.evaluate(part.rows) for term in candidate.terms]
    return all(column.std() < STEADY * abs(column.mean()) for column in columns)


def _grown_forms(candidate: Candidate, grown: Sequence[Candidate]) -> list[Candidate]:
    """Return the other forms of a grown term that grew beside it, and have hardly more nodes.

    One with a number close to one, where the effect has none, is the same form.
    """
    if candidate.name != EVOLVED:
        return []
    return [
        one
        for one in grown
        if (one.name, one.state) == (EVOLVED, candidate.state)
        and one.size <= candidate.size + MORE
        and candidate.form not in (one.form, (with_units(one) or one).form)
    ]


def _rounded(candidate: Candidate, part: Segments) -> list[Candidate]:
    """Return an effect with its sign functions rounded off, as a hyperbolic tangent is."""
    if len(candidate.terms) != 1:
        return []
    (term,) = candidate.terms
    signs = {
        atom.args[0]
        for _, product in term.parts
        for atom, _ in product.factors
        if isinstance(atom, Call) and atom.operator.name == "sgn"
    }
    if len(signs) != 1:
        return []
    (inside,) = signs
    size = float(np.std(inside.evaluate(part.rows)))
    return [Candidate(candidate.name, candidate.state, (_soft(term, inside, ROUNDED * size),))]


def _soft(term: Sum, inside: Sum, width: float) -> Sum:
    """Replace the sign of an expression by its hyperbolic tangent."""
    step = rounded_sign(inside, width)
    parts = []
    for coefficient, product in term.parts:
        replaced = constant(coefficient)
        for atom, exponent in product.factors:
            is_sign = isinstance(atom, Call) and atom.operator.name == "sgn"
            factor = step if is_sign else as_sum(atom)
            replaced = mul(replaced, power(factor, exponent))
        parts.append(replaced)
    return reduce(add, parts)
