"""The alternatives of an effect: others that could stand in its place."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import reduce
from itertools import accumulate, pairwise

import numpy as np

from ...hidden_states.path_states import paths_within
from ...terms import Call, Sum, add, as_sum, constant, mul, power
from ..effects.candidate import OFFSET, Candidate
from ..effects.hysteresis import rounded_sign
from ..effects.missing import candidates, for_trajectories, terms_in, with_parents
from ..effects.names import EVOLVED
from ..effects.shaping import with_units
from ..given.design import Design
from ..given.segments import Segments
from .drifting_rivals import leads_over, twin_chance
from .encompassing import chance, explained
from .held_out_scores import fold_errors
from .same_model import span, span_in
from .scoring import columns_of
from .spectral import spectral_grams

ROUNDED = 0.1  # width of a rounded sign, in standard deviations of its argument
# Share of what an effect explains that a rival must explain in its place. Where much else is
# missing, the test alone refutes nothing, as a large residual could hide anything.
EXPLAINED = 1.0 / 3.0
# A rival with so many times the held-out squares of an effect is outdone.
OUTDONE_SQUARES_RATIO = 2.0
MAX_CONSTANT_SPREAD = 0.1  # standard deviation over mean, below which a term counts as constant
MAX_REFUTED_IN_A_ROW = 3  # stop after this many refuted names in a row: the rest fit worse
MAX_EXTRA_NODES = 2  # extra nodes that another form of a grown term may have


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
    """Return the effects that could stand in the place of another.

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
        Other grown terms: alternative forms, if the effect is grown as well.

    Returns
    -------
    tuple of Rival
        The best form of each name, the least refuted first; other forms of the effect itself
        count as well.
    """
    options = _options(candidate, design, part, grown)
    test = _by_twins if part.by_trajectory else _by_pieces
    return test(candidate, options, design, part, level, rng)


def _options(
    candidate: Candidate, design: Design, part: Segments, grown: Sequence[Candidate]
) -> list[Candidate]:
    """Return the effects that may be tried in the place of another."""
    known = terms_in(design)
    proposed = candidates(design, part.ranges)
    if part.by_trajectory:
        proposed = for_trajectories(proposed)
    proposed += [*_rounded(candidate, part), *_grown_forms(candidate, grown)]
    complete = [_with_offset(c, known) for c in proposed]
    able = with_parents(complete, design)
    if OFFSET in candidate.terms:  # an option with an offset would contain the effect
        able = [c for c in able if c.state != candidate.state or OFFSET not in c.terms]
        able = [c for c in able if not _hardly_varies(c, part)]
    rest = (c for c in dict.fromkeys(able) if _differs(c, candidate, design))
    return [c for c in rest if not _is_form(c, candidate)]


def _by_pieces(
    candidate: Candidate,
    options: Sequence[Candidate],
    design: Design,
    part: Segments,
    level: float,
    rng: np.random.Generator,
) -> tuple[Rival, ...]:
    """Return the alternatives of an effect, tested on the derivatives of pieces of the records.

    These are the least refuted form of each name.
    """
    everything = [column for c in (candidate, *options) for column in columns_of(c, design)]
    grams = spectral_grams(part, design, [*design.columns, *everything])
    first = len(design.columns)
    base, places = tuple(range(first)), _places(first, (candidate, *options))
    own, *others = places
    own_squares, *their_squares = explained(grams, base, places)
    if own_squares <= 0.0:  # the effect explains nothing beside the others any more
        return ()
    best: dict[str, Rival] = {}
    for option, place, squares in zip(options, others, their_squares, strict=True):
        if squares < EXPLAINED * own_squares:
            continue
        p_value = chance(grams, (*base, *place), own, level, rng)
        if p_value > level and _is_outdone(grams, (*base, *place), (*base, *own), part.folds):
            continue
        if p_value > level and _is_same_model(option, candidate, design, part):
            continue
        if p_value > max(level, best[option.name].p_value if option.name in best else 0.0):
            best[option.name] = Rival(option, p_value)
    return tuple(sorted(best.values(), key=lambda rival: -rival.p_value))


def _is_outdone(
    grams: np.ndarray, rival: Sequence[int], own: Sequence[int], folds: np.ndarray
) -> bool:
    """Tell whether a rival predicts held-out pieces much worse than the effect, and most of them.

    The cause would hardly do so by chance. The test misses this where only a few pieces tell the
    two apart, as the scatter over the pieces is then large.
    """
    theirs, ours = (fold_errors(grams, np.array([model]), folds)[0] for model in (rival, own))
    weighed = ours > 0.0  # in a fold before all states have settled nothing is
    most = np.median(theirs[weighed] / ours[weighed]) if weighed.any() else 0.0
    return bool(theirs.sum() > OUTDONE_SQUARES_RATIO * ours.sum() and most > 1.0)


def _differs(option: Candidate, candidate: Candidate, bare: Design) -> bool:
    """Tell whether an option adds something to the bare model, without containing the effect.

    An option that contains the effect, with another sign or name or with more terms, cannot stand
    in its place; nor can one that the model contains already.
    """
    added = columns_of(option, bare)
    with_option = [*bare.columns, *added]
    return not span(bare.columns, added) and not span(with_option, columns_of(candidate, bare))


def _is_same_model(option: Candidate, candidate: Candidate, design: Design, part: Segments) -> bool:
    """Tell whether the effect is but another way to write the model with an option in its place."""
    own, with_option = columns_of(candidate, design), design.adding(columns_of(option, design))
    if any(paths_within(column.parts) for column in (*own, *with_option.columns)):
        return False
    low, high = part.rows.min(axis=0), part.rows.max(axis=0)
    return span_in(with_option.columns, own, low, high)


def _with_offset(candidate: Candidate, known: set[tuple[int, Sum]]) -> Candidate:
    """Return a candidate with the offset that it needs as a term, if the model has none."""
    if OFFSET not in candidate.parents or (candidate.state, OFFSET) in known:
        return candidate
    shape = candidate.shape
    if shape is not None:
        shape = replace(shape, builds=(_offset, *shape.builds))
    beside = candidate.needing_no_offset()
    return replace(beside, terms=(OFFSET, *candidate.terms), shape=shape)


def _offset(*numbers: float) -> Sum:
    """Return the offset, whatever the numbers in the other terms are."""
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

    The closest form of each name is tested, closest names first, until several in a row are
    refuted.
    """
    everything = [candidate, *options]
    leads = leads_over(everything, design, part.records)[1:]
    closest: dict[str, Candidate] = {}
    for k in np.argsort(leads, kind="stable"):
        closest.setdefault(options[k].name, options[k])
    found: list[Rival] = []
    n_refuted = 0
    for option in closest.values():
        p_value = twin_chance(option, design, everything, part.records, level, rng)
        if p_value > level:
            found.append(Rival(option, p_value))
        n_refuted = 0 if p_value > level else n_refuted + 1
        if n_refuted == MAX_REFUTED_IN_A_ROW:
            break
    return tuple(sorted(found, key=lambda rival: -rival.p_value))


def _places(first: int, candidates: Sequence[Candidate]) -> list[tuple[int, ...]]:
    """Return the columns of each candidate, one after the other."""
    ends = list(accumulate((len(one.terms) for one in candidates), initial=first))
    return [tuple(range(*pair)) for pair in pairwise(ends)]


def _is_form(one: Candidate, other: Candidate) -> bool:
    """Tell whether two candidates differ only in the numbers of their shapes."""
    shapes = one.shape, other.shape
    return None not in shapes and (one.name, one.state) == (other.name, other.state)


def _hardly_varies(candidate: Candidate, part: Segments) -> bool:
    """Tell whether an effect is nearly constant, as cos(q) of small angles is."""
    columns = [term.evaluate(part.rows) for term in candidate.terms]
    return all(column.std() < MAX_CONSTANT_SPREAD * abs(column.mean()) for column in columns)


def _grown_forms(candidate: Candidate, grown: Sequence[Candidate]) -> list[Candidate]:
    """Return the other grown terms of its equation that have hardly more nodes than a grown term.

    With a number close to one where the effect has none, it is the same form.
    """
    if candidate.name != EVOLVED:
        return []
    return [
        one
        for one in grown
        if (one.name, one.state) == (EVOLVED, candidate.state)
        and one.size <= candidate.size + MAX_EXTRA_NODES
        and candidate.form not in (one.form, (with_units(one) or one).form)
    ]


def _rounded(candidate: Candidate, part: Segments) -> list[Candidate]:
    """Return an effect with its sign function rounded off to a hyperbolic tangent."""
    if len(candidate.terms) != 1:
        return []
    (term,) = candidate.terms
    arguments = {
        atom.args[0]
        for _, product in term.parts
        for atom, _ in product.factors
        if isinstance(atom, Call) and atom.operator.name == "sgn"
    }
    if len(arguments) != 1:
        return []
    (argument,) = arguments
    size = float(np.std(argument.evaluate(part.rows)))
    return [Candidate(candidate.name, candidate.state, (_soft(term, argument, ROUNDED * size),))]


def _soft(term: Sum, argument: Sum, width: float) -> Sum:
    """Replace the sign of an expression by its hyperbolic tangent."""
    step = rounded_sign(argument, width)
    parts = []
    for coefficient, product in term.parts:
        replaced = constant(coefficient)
        for atom, exponent in product.factors:
            is_sign = isinstance(atom, Call) and atom.operator.name == "sgn"
            factor = step if is_sign else as_sum(atom)
            replaced = mul(replaced, power(factor, exponent))
        parts.append(replaced)
    return reduce(add, parts)
