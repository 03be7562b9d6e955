"""The quotients and powers that a curved function stands for.

A magnet pulls by 1 / (d - q)^2, and so does a charged plate; what passes by at a distance d has
1 / (d^2 + q^2), as has a rate that falls with what there is of its product, and the drag of an
eddy-current brake is v / (c^2 + v^2); a gene is repressed as 1 / (c^4 + p^4); what is hot radiates
by T^4. Over the range of a record each is nearly an exponential or a hyperbolic tangent beside what
the model has, which is easier to find.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np
from scipy.optimize import minimize_scalar

from ...checks import TINY
from ...operators import SCALED
from ...terms import (
    Atom,
    Call,
    Product,
    Sum,
    add,
    constant,
    mul,
    of_term,
    power,
    sub,
    variable,
)
from ..effects.candidate import OFFSET, Candidate, bare
from ..effects.missing import standing
from ..effects.names import EVOLVED
from ..given.design import Design
from ..given.segments import Segments

__all__ = ["as_quotients"]

POWERS = (1, 2)  # of the distance: Coulomb's law in a plane and in space
EXPONENTS = (1, 2, 3, 4, 5)  # of powers that a curved function may be
EVEN = ((0, 2), (1, 2), (0, 4))  # powers of a variable above the line, and below it beside a length
# Logarithms of how far away: in units of what an exponential rises in, or of the largest value.
GRID = np.linspace(-3.0, 4.0, 15)
ENOUGH = 2000  # rows to see how close one term comes to another
CLOSE = 0.3  # of a term beside the others, that what stands for it may miss

Family = Callable[[float], Sum]


def as_quotients(candidate: Candidate, design: Design, part: Segments) -> list[Candidate]:
    """Return a grown term with a quotient or a power in the place of each curved function.

    Parameters
    ----------
    candidate : Candidate
        Any; of what is no grown product with a curved function in it there are none.
    design : Design
        The model without it; an offset that stands there is not offered again.
    part : Segments
        Pieces of the training records: poles lie beyond them.

    Returns
    -------
    list of Candidate
        Each with the number with which it comes closest, beside what the equation has; each by
        itself and beside an offset.
    """
    terms = [term for term in candidate.terms if term != OFFSET]
    if candidate.name != EVOLVED or len(terms) != 1 or len(terms[0].parts) != 1:
        return []
    ((_, product),) = terms[0].parts
    place = _Place.of(product, candidate.state, design, part.rows)
    found = _closest(product, place, part.rows) if place.is_known else ()
    forms = dict.fromkeys(bare(term) for term in found if place.missed(term) <= CLOSE)
    has_offset = (candidate.state, OFFSET) in standing(design)
    offsets: list[tuple[Sum, ...]] = [()] if has_offset else [(), (OFFSET,)]
    return [
        Candidate(EVOLVED, candidate.state, (term, *offset)) for term in forms for offset in offsets
    ]


@dataclass(frozen=True, eq=False)
class _Place:
    """Where a term stands: its values, and those of what the equation has besides, scaled."""

    wanted: np.ndarray
    beside: np.ndarray
    rows: np.ndarray

    @classmethod
    def of(cls, product: Product, state: int, design: Design, rows: np.ndarray) -> _Place:
        """Look at a term beside a design and an offset, on some of the rows."""
        rows = rows[:: max(1, len(rows) // ENOUGH)]
        equation = [OFFSET, *(column.parts[state] for column in design.columns)]
        columns = [side.evaluate(rows) for side in equation if side.parts]
        return cls(product.evaluate(rows), np.column_stack(columns), rows)

    @property
    def is_known(self) -> bool:
        """Whether the term, and all beside it, has a value everywhere."""
        return bool(np.isfinite(self.wanted).all() and np.isfinite(self.beside).all())

    def closest(self, family: Family) -> Sum:
        """Return the one of a family that comes closest to the term."""
        missed = [self.missed(family(x)) for x in np.exp(GRID)]
        # Far away all are alike, so a search over the whole range may end in nothing there.
        around = GRID[np.argmin(missed)] + np.array([-1.0, 1.0]) * (GRID[1] - GRID[0])
        best = minimize_scalar(lambda x: self.missed(family(np.exp(x))), bounds=around)
        return family(float(np.exp(best.x)))

    def missed(self, term: Sum) -> float:
        """Return the part of the term beside the others that another one misses, RMS."""
        values = term.evaluate(self.rows)
        if not np.isfinite(values).all():
            return np.inf
        return self._left(np.column_stack([self.beside, values])) / max(self.own, TINY)

    @cached_property
    def own(self) -> float:
        """Size of the term beside the others."""
        return self._left(self.beside)

    def _left(self, columns: np.ndarray) -> float:
        basis = columns / np.maximum(np.abs(columns).max(axis=0), TINY)
        fitted = basis @ np.linalg.lstsq(basis, self.wanted, rcond=None)[0]
        return float(np.linalg.norm(self.wanted - fitted))


def _closest(product: Product, place: _Place, rows: np.ndarray) -> Iterator[Sum]:
    """Go through the product with each curved function replaced by close quotients, or by powers.

    One of a single variable is replaced with and without all else that depends on that alone.
    """
    for atom in _curved(product):
        (inside,) = atom.args
        if not np.isfinite(inside.evaluate(rows)).all():
            continue
        beside = _without(product, {atom})
        if atom.operator.name == "exp":
            highest = float(inside.evaluate(rows).max())
            distant = (partial(_over_distance, beside, inside, highest, n) for n in POWERS)
            yield from map(place.closest, distant)
        if len(atom.variables) == 1:
            (index,) = atom.variables
            alike = {one for one, _ in product.factors if one.variables == atom.variables}
            for left in dict.fromkeys((beside, _without(product, alike))):
                largest = float(np.abs(rows[:, index]).max())
                yield from map(place.closest, _quotients(left, index, largest))
                yield from (mul(left, power(variable(index), n)) for n in EXPONENTS)


def _curved(product: Product) -> list[Call]:
    """Return the curved functions in a product."""
    calls = [atom for atom, exponent in product.factors if isinstance(atom, Call) and exponent == 1]
    return [one for one in calls if one.operator.name in SCALED]


def _without(product: Product, gone: Collection[Atom]) -> Sum:
    """Return a product without some of its atoms."""
    return of_term(Product(tuple(one for one in product.factors if one[0] not in gone)))


def _quotients(left: Sum, index: int, largest: float) -> Iterator[Family]:
    """Go through quotients of a variable times what else there is."""
    for above, n in EVEN if largest > 0.0 else ():
        yield partial(_over_even, mul(left, power(variable(index), above)), index, largest, n)


def _over_distance(left: Sum, inside: Sum, highest: float, n: int, distance: float) -> Sum:
    """Return a term over a power of the distance to a pole beyond the highest value inside."""
    return mul(left, power(sub(constant(highest + distance), inside), -n))


def _over_even(left: Sum, index: int, largest: float, n: int, length: float) -> Sum:
    """Return a term over even powers of a variable and of a length, in its largest values."""
    below = add(power(variable(index), n), constant((length * largest) ** n))
    return mul(left, power(below, -1))
