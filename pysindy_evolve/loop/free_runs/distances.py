"""The powers of a distance that an exponential stands for: what pulls the more, the closer it is.

A magnet pulls by 1 / (d - q)^2, and so does a charged plate. Over the range of a record this is
nearly an exponential beside an offset and a line, which is easier to find.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.optimize import minimize_scalar

from ...terms import Call, Product, Sum, constant, mul, power, sub
from ..effects.candidate import EVOLVED, OFFSET, Candidate, bare
from ..effects.missing import standing
from ..given.design import Design
from ..given.segments import Segments

__all__ = ["as_distances"]

POWERS = (1, 2)  # of the distance: Coulomb's law in a plane and in space
DISTANCES = (-3.0, 4.0)  # logarithms: how far from a pole, in units of what an exponential rises in


def as_distances(candidate: Candidate, design: Design, part: Segments) -> list[Candidate]:
    """Return a grown exponential as powers of a distance, each by itself and beside an offset.

    Parameters
    ----------
    candidate : Candidate
        Any; of what is no grown product with an exponential in it there are none.
    design : Design
        The model without it; an offset that stands there is not offered again.
    part : Segments
        Pieces of the training records: the pole lies beyond them.

    Returns
    -------
    list of Candidate
    """
    terms = [term for term in candidate.terms if term != OFFSET]
    if candidate.name != EVOLVED or len(terms) != 1 or len(terms[0].parts) != 1:
        return []
    ((_, product),) = terms[0].parts
    forms = [bare(term) for term in _poles(product, part.rows)]
    has_offset = (candidate.state, OFFSET) in standing(design)
    offsets: list[tuple[Sum, ...]] = [()] if has_offset else [(), (OFFSET,)]
    return [
        Candidate(EVOLVED, candidate.state, (term, *offset))
        for term in dict.fromkeys(forms)
        for offset in offsets
    ]


def _poles(product: Product, rows: np.ndarray) -> Iterator[Sum]:
    """Go through the product with each exponential exp(k v) replaced by 1 / (c - k v)^n."""
    for place, (atom, exponent) in enumerate(product.factors):
        if isinstance(atom, Call) and atom.operator.name == "exp" and exponent == 1:
            left = Product(product.factors[:place] + product.factors[place + 1 :])
            (inside,) = atom.args
            acted = inside.evaluate(rows)
            for n in POWERS if np.isfinite(acted).all() else ():
                distance = sub(constant(_nearest_pole(acted, n)), inside)
                yield mul(Sum(((1.0, left),)), power(distance, -n))


def _nearest_pole(x: np.ndarray, n: int) -> float:
    """Return the c for which 1 / (c - x)^n comes closest to exp(x), an offset and a line aside."""
    highest = float(x.max())
    shape = np.exp(x - highest)

    def missed(log_distance: float) -> float:
        pole = highest + np.exp(log_distance)
        basis = np.column_stack([np.ones_like(x), x, (pole - x) ** -float(n)])
        fitted = basis @ np.linalg.lstsq(basis, shape, rcond=None)[0]
        return float(np.sum((shape - fitted) ** 2))

    return highest + float(np.exp(minimize_scalar(missed, bounds=DISTANCES).x))
