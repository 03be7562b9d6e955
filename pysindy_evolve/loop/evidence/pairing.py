"""Which effects may be tried, alone and in pairs: each needs its parents in the equation."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np

from ...terms import Sum
from ..effects.candidate import OFFSET, Candidate
from ..effects.names import EVOLVED

Keys = set[tuple[int, Sum]]


def groups_to_try(
    candidates: Sequence[Candidate], new: Sequence[int], present: Keys, *, pairs: bool
) -> list[tuple[int, ...]]:
    """Return the groups of candidates to try, by their places: single ones, then pairs.

    Parameters
    ----------
    candidates : sequence of Candidate
        What may be missing.
    new : sequence of int
        Places of those that are no combinations of the model's columns.
    present : set of (int, Sum)
        Equation and expression of each term of the model; parents must be among them, or in the
        group.
    pairs : bool
        Whether to try pairs too: not two shapes of one effect, unless they were grown, but one
        force in two equations.

    Returns
    -------
    list of tuple of int
    """
    needs = [_parents(candidates[i]) - present - _terms(candidates[i]) for i in new]
    alone: list[tuple[int, ...]] = [(i,) for i, need in zip(new, needs, strict=True) if not need]
    if not pairs:
        return alone
    pairable = [k for k, i in enumerate(new) if not candidates[i].never_paired]
    able = _able([needs[k] for k in pairable], [_terms(candidates[new[k]]) for k in pairable])
    able &= able.T & _unlike([candidates[new[k]].name for k in pairable])
    places = np.array(new, dtype=int)[pairable]
    first, second = np.nonzero(np.triu(able, 1))
    found = zip(places[first].tolist(), places[second].tolist(), strict=True)
    return [*alone, *found, *_of_one_force(candidates, [i for (i,) in alone])]


def posing_as_offset(
    candidates: Sequence[Candidate], new: Sequence[int], present: Keys
) -> list[tuple[int, int]]:
    """Return the places of each offset that the model lacks and of each effect that may pose as it.

    Parameters
    ----------
    candidates, new, present
        As in `groups_to_try`.

    Returns
    -------
    list of (int, int)
    """
    offsets = {candidates[i].state: i for i in new if candidates[i].terms == (OFFSET,)}
    lacking = ((candidates[i].state, i) for i in new if _lacks_only_offset(candidates[i], present))
    return [(offsets[state], i) for state, i in lacking if state in offsets]


def _lacks_only_offset(candidate: Candidate, present: Keys) -> bool:
    """Tell whether a candidate lacks no parent but the offset.

    One with more parents that may be paired gets its offset as the partner of a pair.
    """
    has_more = candidate.parents != (OFFSET,)
    if has_more and not candidate.never_paired:
        return False
    return _parents(candidate) - present - _terms(candidate) == {(candidate.state, OFFSET)}


def _of_one_force(candidates: Sequence[Candidate], able: Sequence[int]) -> list[tuple[int, ...]]:
    """Return the pairs that are one force at one place, in two equations.

    Each alone explains one equation only, which may not be clear on few segments.
    """
    places: dict[tuple[tuple[int, ...], tuple[Sum, ...]], list[int]] = {}
    for i in able:
        force = candidates[i].acts_at
        if force is not None:
            places.setdefault(force, []).append(i)
    pairs = (pair for group in places.values() for pair in combinations(group, 2))
    return [(i, j) for i, j in pairs if candidates[i].state != candidates[j].state]


def _able(needs: Sequence[Keys], supplied: Sequence[Keys]) -> np.ndarray:
    """Tell where the column's effect has all parents that the row's effect needs."""
    able = np.ones((len(needs), len(needs)), dtype=bool)
    rows: dict[frozenset[tuple[int, Sum]], list[bool]] = {}
    for row, need in zip(able, map(frozenset, needs), strict=True):
        if need:
            if need not in rows:  # many effects need the same offset
                rows[need] = [need <= terms for terms in supplied]
            row[:] = rows[need]
    return able


def _unlike(names: Sequence[str]) -> np.ndarray:
    """Tell which two names differ; grown terms share a name, but differ."""
    codes = np.unique(names, return_inverse=True)[1]
    grown = np.array([name == EVOLVED for name in names], dtype=bool)
    return np.asarray((codes[:, None] != codes) | grown)


def _parents(candidate: Candidate) -> Keys:
    return {(candidate.state, parent) for parent in candidate.parents}


def _terms(candidate: Candidate) -> Keys:
    return {(candidate.state, term) for term in candidate.terms}
