"""Grown terms as candidates, with their parents, and named if the vocabulary has them."""

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

MIN_MEAN_SHARE = 0.3  # share of its RMS that the mean of a term must exceed to pose as an offset


def small_candidates(
    design: Design, part: Segments, operators: Sequence[Operator]
) -> list[Candidate]:
    """Return small terms of the variables that act in each equation that may lack something.

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
        Named if the vocabulary has them. The variables that act are the state, its position, and
        those that are in the equation already.
    """
    variables = part.rows[:, :-1]
    terms = small_terms(operators, variables) if operators else []
    known = candidates(design, part.ranges)
    found = []
    for state in design.open_states:
        acting = _acting(design, state)
        shiftable = has_arbitrary_zero(design, state, part.ranges.signed)
        usable = (term for term in terms if term.variables <= acting)
        found += [named(term, state, known, variables, shiftable) for term in usable]
    return found


def _acting(design: Design, state: int) -> frozenset[int]:
    """Return the variables that act in an equation."""
    position = design.position_of(state)
    own = {state} if position is None else {state, position}
    return frozenset(own).union(*(side.variables for side in design.sides_of(state)))


def has_arbitrary_zero(design: Design, state: int, signed: np.ndarray) -> np.ndarray:
    """Tell which variables may have an arbitrary zero: a population does not.

    Parameters
    ----------
    design : Design
        The model.
    state : int
        The equation; in that of a velocity every variable may, as its position may.
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

    A term without a name that can pose as an offset may enter only beside the offset.

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
        Which of them may have an arbitrary zero, time last.
    declared : sequence of Product
        Terms of its equation; one that the term contains whole counts as one node.

    Returns
    -------
    Candidate
    """
    term = without_turns(term)
    expression = of_term(term)
    for candidate in known:
        if candidate.state == state and candidate.terms == (expression,):
            return Candidate(candidate.name, state, candidate.terms)
    parents = (OFFSET,) if poses_as_offset(term, variables, signed) else ()
    free_nodes = nodes_saved(term, declared)
    angles = {v for c in known if c.name == GRAVITY and c.state == state for v in c.variables}
    name = GRAVITY if any(is_wave_of(term, angle) for angle in angles) else EVOLVED
    return Candidate(name, state, (expression,), parents, free_nodes=free_nodes)


def without_signs(term: Product, variables: np.ndarray) -> list[Product]:
    """Return a term with |x| = x and sgn(x) = 1 for each variable that is positive on all rows.

    Parameters
    ----------
    term : Product
        The term.
    variables : ndarray of shape (n, n_variables)
        States and inputs.

    Returns
    -------
    list of Product
        One term as a rule; several if a sum results.
    """
    plain: dict[int | Call, Sum] = {}
    for i in np.flatnonzero(variables.min(axis=0) > 0.0):
        x = variable(int(i))
        plain[Call(BUILTIN["abs"], (x,))] = x
        plain[Call(BUILTIN["sgn"], (x,))] = OFFSET
    return [part for _, part in substituted(of_term(term), plain).parts]


def nodes_saved(term: Product, declared: Sequence[Product]) -> int:
    """Return how many nodes a term saves if a declared term inside it counts as one node.

    Parameters
    ----------
    term : Product
        The term.
    declared : sequence of Product
        Terms of its equation; the one that saves most counts.

    Returns
    -------
    int
        Zero if it contains none of them, as a factor or inside a function.
    """
    return max((_saved(term, other) for other in declared), default=0)


def _saved(term: Product, declared: Product) -> int:
    """Return how many nodes one declared term saves."""
    inside = [
        _saved(part, declared)
        for atom, _ in term.factors
        for argument in (atom.args if isinstance(atom, Call) else ())
        for _, part in argument.parts
    ]
    if not _is_factor(declared, term):
        return max(inside, default=0)
    rest = div(of_term(term), of_term(declared))
    extra = 0 if rest == OFFSET else rest.size + 1  # and a node for the product
    return max(0, term.size - (1 + extra), *inside)


def _is_factor(declared: Product, term: Product) -> bool:
    """Tell whether a term has all factors of a declared one, to the same or a higher power."""
    powers = dict(term.factors)
    return all(powers.get(atom, 0) * n >= n * n for atom, n in declared.factors)


def poses_as_offset(term: Product | Sum, variables: np.ndarray, signed: np.ndarray) -> bool:
    """Tell whether a term of variables with arbitrary zeros has a notable mean."""
    if not all(signed[v] for v in term.variables):
        return False
    column = term.evaluate(variables)
    return bool(abs(column.mean()) > MIN_MEAN_SHARE * np.sqrt(np.mean(column**2)))
