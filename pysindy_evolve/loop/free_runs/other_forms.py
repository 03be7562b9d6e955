"""Other forms of a grown term: without a factor, as it is near zero, and beside an offset.

A search may end at T^4 / (800 + sqrt(T)), of which only the upper part is meant: the lower one is
where a function hardly bends. And a diode passes exp(k v) - 1: without the one, no number k makes
the exponential alone as close as a worse form is.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from ...terms import Call, Product, Sum, mul, of_term, only_term, power
from ..effects.candidate import OFFSET, Candidate, bare
from ..effects.missing import standing
from ..effects.names import EVOLVED
from ..effects.stops import is_stop, pressed
from ..given.design import Design
from ..given.ranges import Ranges
from ..given.segments import Segments

__all__ = ["other_forms"]

# What functions are near zero: straight lines, and the square that a cosine leaves of a constant.
NEAR_ZERO = {"sin": 1, "tanh": 1, "softsign": 1, "cos": 2}


def other_forms(candidate: Candidate, design: Design, part: Segments) -> list[Candidate]:
    """Return a grown term without each of its factors, as each is near zero, and beside an offset.

    Of an end stop, the contact of curved bodies.

    Parameters
    ----------
    candidate : Candidate
        Grown, or of the vocabulary, which mostly knows its forms.
    design : Design
        The model without it; what stands there is not offered again.
    part : Segments
        Pieces of the training records: what is zero at a place in them needs no offset to be so.

    Returns
    -------
    list of Candidate
    """
    if is_stop(candidate):
        return [replace(pressed(candidate), name=EVOLVED)]
    if candidate.name != EVOLVED or len(candidate.terms) != 1 or len(candidate.terms[0].parts) != 1:
        return []
    product = only_term(candidate.terms[0])
    terms = [*candidate.terms, *_shorter(product), *_straight(product)]
    forms: list[tuple[Sum, ...]] = [(term,) for term in terms[1:]]
    forms += [(term, OFFSET) for term in terms if not _vanishes_at_rest(term, part.rows)]
    known, state = standing(design), candidate.state
    new = (terms for terms in forms if not any((state, term) in known for term in terms))
    return [Candidate(EVOLVED, state, terms) for terms in new]


def _shorter(product: Product) -> Iterator[Sum]:
    for place in range(len(product.factors)):
        left = product.without(place)
        if left.variables:
            yield of_term(left)


def _straight(product: Product) -> Iterator[Sum]:
    """Go through the product with each function replaced by the power that it is near zero."""
    for place, (atom, exponent) in enumerate(product.factors):
        if isinstance(atom, Call) and atom.operator.name in NEAR_ZERO:
            left = product.without(place)
            near = exponent * NEAR_ZERO[atom.operator.name]
            straight = mul(of_term(left), power(atom.args[0], near))
            if len(straight.parts) == 1:
                yield bare(straight)


def _vanishes_at_rest(term: Sum, rows: np.ndarray) -> bool:
    """Tell whether a term is zero where all variables are, and some of its variables come there."""
    signed = Ranges.of(rows).signed
    with np.errstate(all="ignore"):  # 1 / q has no value there
        at_rest = float(term.evaluate(np.zeros((1, rows.shape[1])))[0])
    return at_rest == 0.0 and any(signed[variable] for variable in term.variables)
