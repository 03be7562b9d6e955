"""Other forms of a grown term: without one factor, with another function, beside an offset.

A search may end at T^4 / (800 + sqrt(T)) where T^4 is right, since the denominator hardly changes,
or at w^2 tanh(q) where the angle q swings so far that w^2 sin(q) is clearly closer. And a diode
passes exp(k v) - 1: without the -1, the exponential fits worse than a wrong form does, whatever k
is. The rate of a reaction is exp(-b / T), which exp(a T) follows for a few degrees (Arrhenius, Z.
phys. Chem. 4 (1889), DOI 10.1515/zpch-1889-0416).
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import replace

import numpy as np

from ...breeding.poles import has_pole
from ...operators import BUILTIN, Operator
from ...terms import (
    Call,
    Product,
    Sum,
    call,
    constant,
    mul,
    of_term,
    only_term,
    power,
    variable,
)
from ..effects.candidate import OFFSET, Candidate, bare
from ..effects.frictions import tustin_form
from ..effects.missing import terms_in
from ..effects.names import EVOLVED
from ..effects.stops import is_stop, kinked_at_zero, pressed
from ..given.design import Design
from ..given.ranges import Ranges
from ..given.segments import Segments

# Leading power of each function near zero: straight, and the square by which cos leaves one.
NEAR_ZERO = {"sin": 1, "tanh": 1, "softsign": 1, "cos": 2}
ALIKE = ("sin", "tanh", "softsign")  # straight near zero, and bent differently further away


def other_forms(
    candidate: Candidate, design: Design, part: Segments, operators: Collection[Operator] = ()
) -> list[Candidate]:
    """Return the other forms of a grown term, of stops and of Stribeck friction.

    Those of a grown term lack one factor, or hold a power or a similar function in place of one
    function, or exp(-b / T) for exp(a T) where T stays positive. Each of them, and the term, is
    also offered beside an offset unless the records show that it vanishes at zero.

    Parameters
    ----------
    candidate : Candidate
        Grown. Of the vocabulary, a stop that ends at a place has the contact of curved bodies, one
        with two ends another stiffness above zero, and Stribeck friction that of Tustin.
    design : Design
        The model without it; terms that it already holds are not offered.
    part : Segments
        Pieces of the training records. They say whether variables reach zero.
    operators : collection of Operator
        Basis functions of grown terms, which may take each other's place.

    Returns
    -------
    list of Candidate
    """
    if is_stop(candidate):
        return [replace(pressed(candidate), name=EVOLVED)]
    renamed = kinked_at_zero(candidate) or tustin_form(candidate)
    if renamed is not None:
        return [renamed]
    if candidate.name != EVOLVED or len(candidate.terms) != 1 or len(candidate.terms[0].parts) != 1:
        return []
    product = only_term(candidate.terms[0])
    others = [
        *_shorter(product),
        *_straight(product),
        *_bent_alike(product, operators),
        *_activated(product, part.ranges),
    ]
    forms: list[tuple[Sum, ...]] = [(term,) for term in others]
    not_zero = (t for t in (*candidate.terms, *others) if not _vanishes_at_rest(t, part.rows))
    forms += [(term, OFFSET) for term in not_zero]
    known, state = terms_in(design), candidate.state
    new = (form for form in forms if not any((state, term) in known for term in form))
    return [
        Candidate(EVOLVED, state, form)
        for form in new
        if not any(has_pole(term, part.rows) for term in form)
    ]


def _shorter(product: Product) -> Iterator[Sum]:
    for place in range(len(product.factors)):
        rest = product.without(place)
        if rest.variables:
            yield of_term(rest)


def _straight(product: Product) -> Iterator[Sum]:
    """Yield the product with each function replaced by its leading power near zero."""
    for place, (atom, exponent) in enumerate(product.factors):
        if isinstance(atom, Call) and atom.operator.name in NEAR_ZERO:
            rest = product.without(place)
            leading = exponent * NEAR_ZERO[atom.operator.name]
            straight = mul(of_term(rest), power(atom.args[0], leading))
            if len(straight.parts) == 1 and straight.variables:
                yield bare(straight)


def _bent_alike(product: Product, operators: Collection[Operator]) -> Iterator[Sum]:
    """Yield the product with each function replaced by those that look like it near zero."""
    alike = [BUILTIN[name] for name in ALIKE if BUILTIN[name] in operators]
    for place, (atom, exponent) in enumerate(product.factors):
        if isinstance(atom, Call) and atom.operator in alike:
            rest = of_term(product.without(place))
            for other in (other for other in alike if other != atom.operator):
                yield mul(rest, power(call(other, *atom.args), exponent))


def _activated(product: Product, ranges: Ranges) -> Iterator[Sum]:
    """Yield the product with exp(a x) replaced by exp(-b / x) of the same slope in the middle."""
    for place, (atom, exponent) in enumerate(product.factors):
        if not isinstance(atom, Call) or atom.operator != BUILTIN["exp"]:
            continue
        slope, index = atom.args[0].parts[0][0], min(atom.args[0].variables)
        x = variable(index)
        if atom.args[0] == mul(constant(slope), x) and ranges.stays_positive(index):
            b = slope * ranges.middle[index] ** 2
            activated = call(BUILTIN["exp"], mul(constant(-b), power(x, -1)))
            yield mul(of_term(product.without(place)), power(activated, exponent))


def _vanishes_at_rest(term: Sum, rows: np.ndarray) -> bool:
    """Tell whether a term is zero at the origin, and one of its variables changes its sign."""
    signed = Ranges.of(rows).signed
    with np.errstate(all="ignore"):  # 1 / q has no value there
        at_rest = float(term.evaluate(np.zeros((1, rows.shape[1])))[0])
    return at_rest == 0.0 and any(signed[variable] for variable in term.variables)
