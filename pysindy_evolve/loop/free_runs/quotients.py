"""The quotients and powers that a curved function stands for.

Examples are 1 / (d - q)^2 of a magnet or a charged plate; 1 / (d^2 + q^2) of a body that passes at
a distance d, or of a rate that its product inhibits; v / (c^2 + v^2) of an eddy-current brake;
1 / (c^4 + p^4) of a repressed gene; and T^4 of radiation. Over the range of a record each is nearly
an exponential or a hyperbolic tangent plus terms of the model, and these are easier to find.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np
from scipy.optimize import minimize_scalar

from ...checks import TINY
from ...operators import SCALED
from ...terms import Atom, Call, Product, Sum, add, constant, mul, of_term, power, sub, variable
from ..effects.candidate import OFFSET, Candidate, bare
from ..effects.missing import terms_in
from ..effects.names import EVOLVED
from ..given.design import Design
from ..given.segments import Segments

POWERS = (1, 2)  # of the distance to a pole: Coulomb's law in a plane and in space
EXPONENTS = (1, 2, 3, 4, 5)  # of powers that may replace a curved function
EVEN_EXPONENTS = ((0, 2), (1, 2), (0, 4))  # (m, n) of x^m / (x^n + length^n)
# Logarithms of the distance to a pole, in units of the argument of the exponential, or of the
# length, in units of the largest value of the variable.
GRID = np.linspace(-3.0, 4.0, 15)
N_COMPARED_ROWS = 2000  # rows on which terms are compared
MAX_MISSED_SHARE = 0.3  # largest share that a replacement may miss, see `_Place.missed`

Family = Callable[[float], Sum]


def as_quotients(candidate: Candidate, design: Design, part: Segments) -> list[Candidate]:
    """Return a grown term with a quotient or a power in the place of each curved function.

    Parameters
    ----------
    candidate : Candidate
        Any effect; only a grown product with a curved function in it has replacements.
    design : Design
        The model without it; an offset that it already holds is not offered.
    part : Segments
        Pieces of the training records: poles lie beyond them.

    Returns
    -------
    list of Candidate
        Each with the number that fits the term best, given the rest of its equation; each also
        beside an offset.
    """
    terms = [term for term in candidate.terms if term != OFFSET]
    if candidate.name != EVOLVED or len(terms) != 1 or len(terms[0].parts) != 1:
        return []
    ((_, product),) = terms[0].parts
    place = _Place.of(product, candidate.state, design, part.rows)
    found = _closest(product, place, part.rows) if place.is_known else ()
    forms = dict.fromkeys(bare(term) for term in found if place.missed(term) <= MAX_MISSED_SHARE)
    has_offset = (candidate.state, OFFSET) in terms_in(design)
    offsets: list[tuple[Sum, ...]] = [()] if has_offset else [(), (OFFSET,)]
    return [
        Candidate(EVOLVED, candidate.state, (term, *offset)) for term in forms for offset in offsets
    ]


@dataclass(frozen=True, eq=False)
class _Place:
    """Values of a term on some rows, and of the other columns of its equation."""

    wanted: np.ndarray
    beside: np.ndarray
    rows: np.ndarray

    @classmethod
    def of(cls, product: Product, state: int, design: Design, rows: np.ndarray) -> _Place:
        """Evaluate a term, the columns of a design and an offset on some of the rows."""
        rows = rows[:: max(1, len(rows) // N_COMPARED_ROWS)]
        equation = [OFFSET, *(column.parts[state] for column in design.columns)]
        columns = [side.evaluate(rows) for side in equation if side.parts]
        return cls(product.evaluate(rows), np.column_stack(columns), rows)

    @property
    def is_known(self) -> bool:
        """Whether the term and the other columns are finite on all rows."""
        return bool(np.isfinite(self.wanted).all() and np.isfinite(self.beside).all())

    def closest(self, family: Family) -> Sum:
        """Return the member of a family that comes closest to the term."""
        missed = [self.missed(family(x)) for x in np.exp(GRID)]
        # Far away all members look alike, so a search over the whole range may end there.
        around = GRID[np.argmin(missed)] + np.array([-1.0, 1.0]) * (GRID[1] - GRID[0])
        best = minimize_scalar(lambda x: self.missed(family(np.exp(x))), bounds=around)
        return family(float(np.exp(best.x)))

    def missed(self, term: Sum) -> float:
        """Return the share that another term misses of what the other columns do not explain."""
        values = term.evaluate(self.rows)
        if not np.isfinite(values).all():
            return np.inf
        return self._left(np.column_stack([self.beside, values])) / max(self.own, TINY)

    @cached_property
    def own(self) -> float:
        """Norm of what the other columns do not explain of the term."""
        return self._left(self.beside)

    def _left(self, columns: np.ndarray) -> float:
        basis = columns / np.maximum(np.abs(columns).max(axis=0), TINY)
        fitted = basis @ np.linalg.lstsq(basis, self.wanted, rcond=None)[0]
        return float(np.linalg.norm(self.wanted - fitted))


def _closest(product: Product, place: _Place, rows: np.ndarray) -> Iterator[Sum]:
    """Yield the product with each curved function replaced by its closest quotients, or by powers.

    A function of a single variable is replaced alone, and with all other factors of that variable.
    """
    for atom in _curved(product):
        (inside,) = atom.args
        if not np.isfinite(inside.evaluate(rows)).all():
            continue
        beside = _without(product, {atom})
        if atom.operator.name == "exp":
            highest = float(inside.evaluate(rows).max())
            families = (partial(_over_distance, beside, inside, highest, n) for n in POWERS)
            yield from map(place.closest, families)
        if len(atom.variables) == 1:
            (index,) = atom.variables
            same_variable = {one for one, _ in product.factors if one.variables == atom.variables}
            for rest in dict.fromkeys((beside, _without(product, same_variable))):
                largest = float(np.abs(rows[:, index]).max())
                yield from map(place.closest, _quotients(rest, index, largest))
                yield from (mul(rest, power(variable(index), n)) for n in EXPONENTS)


def _curved(product: Product) -> list[Call]:
    """Return the curved functions in a product."""
    calls = [atom for atom, exponent in product.factors if isinstance(atom, Call) and exponent == 1]
    return [one for one in calls if one.operator.name in SCALED]


def _without(product: Product, dropped: Collection[Atom]) -> Sum:
    """Return a product without some of its atoms."""
    return of_term(Product(tuple(one for one in product.factors if one[0] not in dropped)))


def _quotients(rest: Sum, index: int, largest: float) -> Iterator[Family]:
    """Yield the families of quotients of a variable, times the rest of the product."""
    for m, n in EVEN_EXPONENTS if largest > 0.0 else ():
        yield partial(_over_even, mul(rest, power(variable(index), m)), index, largest, n)


def _over_distance(rest: Sum, inside: Sum, highest: float, n: int, distance: float) -> Sum:
    """Divide a term by a power of the distance to a pole beyond the largest value of `inside`."""
    return mul(rest, power(sub(constant(highest + distance), inside), -n))


def _over_even(rest: Sum, index: int, largest: float, n: int, length: float) -> Sum:
    """Divide a term by x^n + (length * largest)^n, with even n."""
    below = add(power(variable(index), n), constant((length * largest) ** n))
    return mul(rest, power(below, -1))
