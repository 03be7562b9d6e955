"""Grown terms as candidates: under a name of the vocabulary where one fits, with their parents."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...operators import BUILTIN, Operator
from ...substitution import substituted
from ...terms import Call, Product, Sum, div, of_term, variable
from ..effects.angles import is_wave_of, without_turns
from ..effects.candidate import OFFSET, Candidate
from ..effects.missing import candidates
from ..effects.names import EVOLVED, GRAVITY
from ..given.design import Design
from ..given.segments import Segments
from .seeds import small_terms

__all__ = ["named", "shifted", "small_candidates", "sparing", "without_signs"]

MEAN = 0.3  # of a term's RMS, from which on it can pose as an offset


def small_candidates(
    design: Design, part: Segments, operators: Sequence[Operator]
) -> list[Candidate]:
    """Return the small terms of what acts in each equation that may lack something.

    Parameters
    ----------
    design : Design
        The model so far.
    part : Segments
        Pieces of records; the sizes of variables set the numbers in curved functions.
    operators : sequence of Operator
        Basis functions; without any there are no terms.

    Returns
    -------
    list of Candidate
        Those of the vocabulary under their names. What acts is the state itself, its position, and
        what stands in the equation already.
    """
    variables = part.rows[:, :-1]
    terms = small_terms(operators, variables) if operators else []
    known = candidates(design, part.ranges)
    found = []
    for state in design.open_states:
        acting, anywhere = _acting(design, state), shifted(design, state, part.ranges.signed)
        able = (term for term in terms if term.variables <= acting)
        found += [named(term, state, known, variables, anywhere) for term in able]
    return found


def _acting(design: Design, state: int) -> frozenset[int]:
    """Return the variables that act in an equation."""
    position = design.position_of(state)
    own = {state} if position is None else {state, position}
    return frozenset(own).union(*(side.variables for side in design.sides_of(state)))


def shifted(design: Design, state: int, signed: np.ndarray) -> np.ndarray:
    """Return which variables may be measured from anywhere: a population may not.

    Parameters
    ----------
    design : Design
        The model.
    state : int
        Equation in question; a position may be measured from anywhere.
    signed : ndarray of bool of shape (n_variables + 1,)
        Which variables change their sign.

    Returns
    -------
    ndarray of bool of shape (n_variables + 1,)
    """
    return signed if design.position_of(state) is None else np.ones_like(signed)


def named(
    term: Product,
    state: int,
    known: Sequence[Candidate],
    variables: np.ndarray,
    signed: np.ndarray,
    declared: Sequence[Product] = (),
) -> Candidate:
    """Return a grown term as a candidate, named if it is an effect of the vocabulary.

    One that poses as an offset may enter only beside the offset, as in the vocabulary.

    Parameters
    ----------
    term : Product
        The term.
    state : int
        Its equation.
    known : sequence of Candidate
        The vocabulary.
    variables : ndarray of shape (n, n_variables)
        States and inputs.
    signed : ndarray of bool of shape (n_variables + 1,)
        Which of them may be measured from anywhere, time last.
    declared : sequence of Product
        Terms of its equation, of which one that it holds whole counts as one node.

    Returns
    -------
    Candidate
    """
    term = without_turns(term)
    expression = of_term(term)
    for candidate in known:
        if candidate.state == state and candidate.terms == (expression,):
            return Candidate(candidate.name, state, candidate.terms)
    poses = _poses_as_offset(term, variables, signed)
    parents, spared = (OFFSET,) if poses else (), sparing(term, declared)
    angles = {v for c in known if c.name == GRAVITY and c.state == state for v in c.variables}
    name = GRAVITY if any(is_wave_of(term, angle) for angle in angles) else EVOLVED
    return Candidate(name, state, (expression,), parents, free_nodes=spared)


def without_signs(term: Product, variables: np.ndarray) -> list[Product]:
    """Return a term without magnitudes and signs of what is positive on all rows.

    Parameters
    ----------
    term : Product
        The term.
    variables : ndarray of shape (n, n_variables)
        States and inputs.

    Returns
    -------
    list of Product
        One, as a rule; its parts if it is a sum without them.
    """
    plain: dict[int | Call, Sum] = {}
    for i in np.flatnonzero(variables.min(axis=0) > 0.0):
        x = variable(int(i))
        plain[Call(BUILTIN["abs"], (x,))] = x
        plain[Call(BUILTIN["sgn"], (x,))] = OFFSET
    return [part for _, part in substituted(of_term(term), plain).parts]


def sparing(term: Product, declared: Sequence[Product]) -> int:
    """Return how many nodes a term has less if a declared one that it holds whole counts as one.

    Parameters
    ----------
    term : Product
        The term.
    declared : sequence of Product
        Terms of its equation; the one counts that spares most.

    Returns
    -------
    int
        Zero if it holds none, as a factor or inside of a function.
    """
    return max((_spared(term, one) for one in declared), default=0)


def _spared(term: Product, declared: Product) -> int:
    """Return how many nodes one declared term spares."""
    inside = [
        _spared(part, declared)
        for atom, _ in term.factors
        for argument in (atom.args if isinstance(atom, Call) else ())
        for _, part in argument.parts
    ]
    if not _is_factor(declared, term):
        return max(inside, default=0)
    rest = div(of_term(term), of_term(declared))
    beside = 0 if rest == OFFSET else rest.size + 1  # with the product of the two
    return max(0, term.size - (1 + beside), *inside)


def _is_factor(declared: Product, term: Product) -> bool:
    """Tell whether a term holds all powers of another one, or higher ones."""
    powers = dict(term.factors)
    return all(powers.get(atom, 0) * n >= n * n for atom, n in declared.factors)


def _poses_as_offset(term: Product, variables: np.ndarray, signed: np.ndarray) -> bool:
    """Tell whether a term of variables that change their sign has a mean that matters."""
    if not all(signed[v] for v in term.variables):
        return False
    column = term.evaluate(variables)
    return bool(abs(column.mean()) > MEAN * np.sqrt(np.mean(column**2)))
