"""Terms that could stand in for an effect, as its free runs show to first order.

What a filter makes look alike, a search by derivatives ranks by chance, and may not offer at all.
The runs of a model with an effect that only resembles what really acts stay so close to those of
the right model that the small changes between them tell what each term would make of the record.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...terms import Sum
from ..effects.candidate import Candidate
from ..effects.missing import standing
from ..evidence.scoring import PRICE, columns_of
from .drift import Drift, gains_of_terms

__all__ = ["stand_ins"]

N_FAMILIES = 12  # of terms, whose numbers are looked at more closely
FACTORS = (0.55, 0.67, 0.82, 1.22, 1.5, 1.8)  # of these numbers, which stand on a coarse grid
N_SHOWN = 3  # that are fitted by their runs
CHUNK = 200  # terms that are looked at at a time, so that memory does not grow with them


def stand_ins(
    drift: Drift, own: Candidate, terms: Sequence[Candidate], least: float
) -> list[Candidate]:
    """Return the terms that bring the runs of a model closest to the record.

    Parameters
    ----------
    drift : Drift
        The model with the effect, which was the last to come.
    own : Candidate
        The effect.
    terms : sequence of Candidate
        Terms to choose from. Those in which nothing acts that acts in the effect are left out.
    least : float
        Log error that a term must gain in the place of the effect; one that is longer must gain
        the price of its nodes.

    Returns
    -------
    list of Candidate
        Best first, one of those that differ in their numbers only; none where the effect leaves
        nothing that a term explains.
    """
    acting = _variables(own)
    able = [c for c in terms if c.state == own.state and acting & _variables(c)]
    able = [c for c in able if c.terms != own.terms and _may_enter(c, drift)]
    leaders = [c for c, _ in _of_families(able, _gains(drift, own, able))[:N_FAMILIES]]
    finer = [_scaled(c, factor) for c in leaders for factor in FACTORS]
    near = list(dict.fromkeys([*leaders, *finer]))
    prices = PRICE * np.maximum([c.size - own.size for c in near], 0)
    net = _gains(drift, own, near) - np.maximum(prices, least)
    return [c for c, gain in _of_families(near, net)[:N_SHOWN] if gain > 0.0]


def _gains(drift: Drift, own: Candidate, terms: Sequence[Candidate]) -> np.ndarray:
    """Return what each term gains in the place of an effect, shape (n_terms,)."""
    groups = [columns_of(c, drift.model.design) for c in terms]
    chunks = [groups[i : i + CHUNK] for i in range(0, len(groups), CHUNK)]
    gains = [gains_of_terms(drift, chunk, n_replaced=len(own.terms)) for chunk in chunks]
    return np.concatenate([np.empty(0), *gains])


def _of_families(terms: Sequence[Candidate], gains: np.ndarray) -> list[tuple[Candidate, float]]:
    """Return the best of the terms that differ in their numbers only, best first."""
    best: dict[tuple[Sum, ...], tuple[Candidate, float]] = {}
    for k in np.argsort(-gains, kind="stable").tolist():
        best.setdefault(_scaled(terms[k], None).terms, (terms[k], float(gains[k])))
    return list(best.values())


def _scaled(candidate: Candidate, factor: float | None) -> Candidate:
    """Return a term with all its numbers times a factor, or all of them one."""
    terms = (
        term.with_constants([1.0 if factor is None else factor * c for c in term.constants])
        for term in candidate.terms
    )
    return replace(candidate, terms=tuple(terms))


def _variables(candidate: Candidate) -> frozenset[int]:
    return frozenset().union(*(term.variables for term in candidate.terms))


def _may_enter(candidate: Candidate, drift: Drift) -> bool:
    present = standing(drift.model.design)
    return all((candidate.state, parent) in present for parent in candidate.parents)
