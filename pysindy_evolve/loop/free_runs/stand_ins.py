"""Terms that could stand in for an effect, as its free runs show to first order.

What a filter makes look alike, a search by derivatives ranks by chance, and may not offer at all.
The runs of a model with an effect that only resembles what really acts stay so close to those of
the right model that the small changes between them tell what each term would make of the record.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...terms import Sum
from ..effects.candidate import Candidate
from ..effects.missing import standing
from ..evidence.scoring import PRICE, columns_of
from .drift import Drift, gains_of_terms

__all__ = ["stand_ins"]

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
    others = [c for c in terms if c.state == own.state and acting & _variables(c)]
    able = [c for c in others if c.terms != own.terms and _may_enter(c, drift)]
    chunks = [able[i : i + CHUNK] for i in range(0, len(able), CHUNK)]
    gains = np.concatenate([np.empty(0), *(_gains(drift, own, chunk) for chunk in chunks)])
    prices = PRICE * np.maximum([c.size - own.size for c in able], 0)
    net = gains - np.maximum(prices, least)
    best: dict[tuple[Sum, ...], Candidate] = {}
    for k in np.argsort(-net).tolist():
        if net[k] > 0.0:
            best.setdefault(_family(able[k]), able[k])
    return list(best.values())[:N_SHOWN]


def _family(candidate: Candidate) -> tuple[Sum, ...]:
    return tuple(term.with_constants([1.0] * len(term.constants)) for term in candidate.terms)


def _gains(drift: Drift, own: Candidate, terms: Sequence[Candidate]) -> np.ndarray:
    groups = [columns_of(c, drift.model.design) for c in terms]
    return gains_of_terms(drift, groups, n_replaced=len(own.terms))


def _variables(candidate: Candidate) -> frozenset[int]:
    return frozenset().union(*(term.variables for term in candidate.terms))


def _may_enter(candidate: Candidate, drift: Drift) -> bool:
    present = standing(drift.model.design)
    return all((candidate.state, parent) in present for parent in candidate.parents)
