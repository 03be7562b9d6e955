"""The numbers inside an effect, such as the rate of an exponential, as a shape to be tuned."""

from __future__ import annotations

from collections.abc import Set
from dataclasses import replace
from functools import partial

import numpy as np

from ...operators import SCALED
from ...terms import Atom, Call, Product, Sum, constant, mul, of_term, simplified
from .angles import UNITS
from .candidate import OFFSET, Candidate, Shape

HALF_SATURATION = "half-saturation constant"  # c of x/(c + |x|), which is built from 1/c
DENOMINATOR = "constant in the denominator"  # c of |x|^n/(c + |x|^n), which is built from 1/c
EXPONENT = "exponent"
INNER = "inner constant"
FROM_RECIPROCALS = (HALF_SATURATION, DENOMINATOR)

MOST_NUMBERS = 3  # in a term; one with more was grown to fit noise
ORDINALS = ("first", "second", "third")
MAX_UNIT_ERROR = 0.1  # relative error of the number in sin(1 q) that noise of an angle makes


def shape_of(candidate: Candidate, known: Set[float] = frozenset()) -> Shape | None:
    """Return the numbers of an effect and how to build its terms.

    Parameters
    ----------
    candidate : Candidate
        Of the vocabulary or grown.
    known : set of float
        Numbers that the declared model gives, such as the masses in a friction at a joint.

    Returns
    -------
    Shape or None
        None if there is no number in it that could be tuned, or too many of them.
    """
    if candidate.shape is not None:
        return candidate.shape
    first, *rest = candidate.terms
    term, numbers = first.parts[0][1], np.array(first.parts[0][1].constants)
    if known and set(np.abs(numbers)) & known:
        return None
    if not len(numbers):  # exp(v) is exp(1 v)
        term = _with_numbers(term)
        numbers = np.ones(len(term.constants))
    is_product = len(first.parts) == 1 and all(one == OFFSET for one in rest)
    if not is_product or not 0 < len(numbers) <= MOST_NUMBERS or not numbers.all():
        return None
    build = partial(_built, term, np.sign(numbers))
    return Shape(tuple(np.abs(numbers).tolist()), (build, *(offset_of for _ in rest)))


def tuned_shape(candidate: Candidate, known: Set[float] = frozenset()) -> Shape | None:
    """Return the numbers inside an effect that were tuned to a record, with their meanings.

    Parameters
    ----------
    candidate : Candidate
        Of the vocabulary or grown.
    known : set of float
        Numbers that the declared model gives.

    Returns
    -------
    Shape or None
        None if there is no such number: neither the 1 in sin(1 q) nor the degree in radians was
        tuned.
    """
    shape = shape_of(candidate, known)
    products = [product for term in candidate.terms for _, product in term.parts]
    tuned = {abs(number) for product in products for number in product.constants} - set(UNITS)
    if candidate.shape is None and not tuned:
        return None
    if shape is None or shape.meanings:
        return shape
    # A sum times a function holds the function once in each of its products.
    atoms = dict.fromkeys(atom for one in products for atom, _ in one.factors)
    kinds = [kind for atom in atoms for kind in _kinds(atom)]
    if len(kinds) != len(shape.values):  # built from few numbers, or exp(v), which is exp(1 v)
        kinds = [INNER] * len(shape.values)
    if len(set(kinds)) < len(kinds):
        kinds = [f"{which} {kind}" for which, kind in zip(ORDINALS, kinds, strict=False)]
    return replace(shape, meanings=tuple(kinds))


def _kinds(atom: Atom) -> list[str]:
    """Return what each number in a function means: in x/(c + |x|), it is printed as it is there."""
    if isinstance(atom, Call) and atom.is_power and len(atom.constants) == 1:
        return [EXPONENT]
    if isinstance(atom, Call) and atom.operator.name == "softsign":
        inner = [factor for _, term in atom.args[0].parts for factor, _ in term.factors]
        is_hill = len(inner) == 1 and isinstance(inner[0], Call) and inner[0].is_power
        if is_hill and len(atom.constants) == 2:
            return [DENOMINATOR, EXPONENT]
        if len(atom.constants) == 1:
            return [HALF_SATURATION]
    return [INNER] * len(atom.constants)


def with_units(candidate: Candidate) -> Candidate | None:
    """Return an effect with units of angles in the place of close numbers, as in sin(0.99 q).

    Parameters
    ----------
    candidate : Candidate
        Of the vocabulary or grown.

    Returns
    -------
    Candidate or None
        With 1, or the degree in radians. None if no number is close to them, or if the effect has a
        shape, such as the width of a dead zone.
    """
    parts = [part for term in candidate.terms for part in term.parts]
    if candidate.shape is not None or len(parts) != 1:
        return None
    weight, term = parts[0]
    rounded = [_rounded(number) for number in term.constants]
    if rounded == list(term.constants):
        return None
    return replace(candidate, terms=(Sum(((weight, term.with_constants(rounded)),)),))


def _rounded(number: float) -> float:
    near = (
        np.copysign(unit, number)
        for unit in UNITS
        if abs(abs(number) / unit - 1.0) <= MAX_UNIT_ERROR
    )
    return float(next(near, number))


def _with_numbers(term: Product) -> Product:
    """Return a term with some number before the argument of each curved function."""
    return simplified(
        tuple(
            (Call(atom.operator, tuple(mul(constant(2.0), a) for a in atom.args)), n)
            if isinstance(atom, Call) and atom.operator.name in SCALED
            else (atom, n)
            for atom, n in term.factors
        )
    )


def offset_of(*_: float) -> Sum:
    """Return a constant, whatever the numbers: a column beside that with the numbers in it."""
    return OFFSET


def _built(term: Product, signs: np.ndarray, *values: float) -> Sum:
    constants = [float(s * v) for s, v in zip(signs, values, strict=True)]
    return of_term(term.with_constants(constants))
