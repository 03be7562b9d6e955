"""Effects that share their numbers: one expression, in the equations of several states.

A force between two bodies acts on both of them, and one input may drive several states. A number
inside such an expression, such as the gap of a clutch, is one number and not two. Tuned one after
the other, each of two would make up for the error of the other: a step along either leads uphill
where a step along both leads down. The equations may multiply it by different variables, as the
grip of a tyre turns a car, and over its speed turns its path.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from ...terms import Sum
from .candidate import Candidate, bare


def are_partners(one: Candidate, other: Candidate) -> bool:
    """Tell whether effects of two equations are one expression, up to factors and its numbers."""
    if one.state == other.state or one.shape is None or other.shape is None:
        return False
    if len(one.shape.values) != len(other.shape.values):
        return False
    aligned = other.at(one.shape.values)
    pairs = list(zip(one.terms, aligned.terms, strict=False))
    return len(one.terms) == len(aligned.terms) and all(_is_one(*pair) for pair in pairs)


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


def joined(candidates: Sequence[Candidate]) -> Candidate:
    """Return partners as one effect of several equations, tuned together from where they are."""
    first, *others = candidates
    return replace(first, parents=(), partners=tuple(others))
