"""Effects that share their numbers: one expression, in the equations of several states.

A force between two bodies acts on both of them, and one input may drive several states. A number
inside such an expression, such as the gap of a clutch, is one number and not two. Tuned one after
the other, each of two would make up for the error of the other: a step along either leads uphill
where a step along both leads down. The equations may multiply it by different variables, as the
grip of a tyre turns a car, and over its speed turns its path.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from ...terms import Sum
from ..given.design import Column, Design
from .candidate import Candidate, bare
from .missing import terms_in


def are_partners(one: Candidate, other: Candidate) -> bool:
    """Tell whether effects of two equations are one expression, up to factors and its numbers."""
    if one.state == other.state or one.shape is None or other.shape is None:
        return False
    if len(one.shape.values) != len(other.shape.values):
        return False
    aligned = other.at(one.shape.values)
    if len(one.terms) != len(aligned.terms):
        return False
    return all(map(_is_one, one.terms, aligned.terms))


def _is_one(term: Sum, other: Sum) -> bool:
    """Tell whether two terms are one expression, or hold the same functions with all numbers."""
    tuned, of_other = _with_numbers(term), _with_numbers(other)
    return bare(term) == bare(other) or (all(tuned) and tuned == of_other)


def _with_numbers(term: Sum) -> list[frozenset[tuple[object, int]]]:
    """Return the factors with numbers in them, of each product of a term."""
    return [
        frozenset((atom, n) for atom, n in product.factors if atom.constants)
        for _, product in term.parts
    ]


def shares_number(one: Candidate, other: Candidate) -> bool:
    """Tell whether two effects are partners with the same numbers in them."""
    if one.shape is None or other.shape is None or one.shape.values != other.shape.values:
        return False
    return are_partners(one, other)


def partnerships(candidates: Sequence[Candidate]) -> list[list[int]]:
    """Return the groups of two or more partners, by their places."""
    groups: list[list[int]] = []
    for place, candidate in enumerate(candidates):
        matching = (g for g in groups if are_partners(candidates[g[0]], candidate))
        group = next(matching, None)
        if group is None:
            groups.append([place])
        elif all(candidates[k].state != candidate.state for k in group):
            group.append(place)
    return [group for group in groups if len(group) > 1]


def acting_in(states: Sequence[int], offered: Sequence[Candidate]) -> Iterator[Candidate]:
    """Yield the effects that are offered in several equations, with the same numbers in them."""
    first, *others = ([one for one in offered if one.state == state] for state in states)
    for one in first:
        partners = [next((c for c in there if _is_same(one, c)), None) for there in others]
        found = [partner for partner in partners if partner is not None]
        if len(found) == len(partners):
            yield joined([one, *found])


def shared_effects(design: Design, offered: Sequence[Candidate]) -> list[Candidate]:
    """Return the effects that change declared terms with one coefficient in several equations.

    What one species loses another gains at one rate. An effect of one of these equations alone
    would change the rate in the others as well.

    Parameters
    ----------
    design : Design
        The model.
    offered : sequence of Candidate
        Effects of single equations.

    Returns
    -------
    list of Candidate
        Effects whose terms hold all variables of such a term, in all of its equations.
    """
    present, found = terms_in(design), list[Candidate]()
    for column, states in shared_terms(design):
        variables = column.parts[states[0]].variables
        able = [
            one
            for one in offered
            if variables <= one.variables
            and {(one.state, parent) for parent in one.parents} <= present
        ]
        found += acting_in(states, able)
    return list(dict.fromkeys(found))


def shared_terms(design: Design) -> Iterator[tuple[Column, list[int]]]:
    """Yield what stands in several equations with one coefficient, and in which equations.

    It is one term if it holds the same variables in all of them: two pumps of one make are two.
    """
    for column in design.columns:
        states = [state for state in design.open_states if column.parts[state].variables]
        acting = {column.parts[state].variables for state in states}
        if len(states) > 1 and len(acting) == 1:
            yield column, states


def _is_same(one: Candidate, other: Candidate) -> bool:
    """Tell whether two effects have one name and one expression, up to factors."""
    equal = [bare(term) for term in one.terms] == [bare(term) for term in other.terms]
    return one.name == other.name and (equal or shares_number(one, other))


def joined(candidates: Sequence[Candidate]) -> Candidate:
    """Return partners as one effect of several equations, tuned together from where they are."""
    first, *others = candidates
    return replace(first, parents=(), partners=tuple(others), never_paired=True)


def apart(shared: Candidate) -> tuple[Candidate, ...]:
    """Return an effect of several equations as one of each."""
    return replace(shared, partners=()), *shared.partners
