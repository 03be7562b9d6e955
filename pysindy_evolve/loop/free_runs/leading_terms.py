"""Terms that bring the runs of a model closest to the record, to first order.

What a filter makes look alike, a search by derivatives ranks by chance, and may not offer at all.
The runs of a model that lacks little, or has something only similar in its place, stay so close to
those of the right one that small changes of them tell what each term would make of the record.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..effects.candidate import Candidate
from ..effects.missing import with_parents
from ..evidence.scoring import PRICE, columns_of
from .drift import Drift, gains_of_terms

__all__ = ["leading_terms", "stand_ins"]

N_FAMILIES = 12  # of terms, whose numbers are looked at more closely
FACTORS = (0.55, 0.67, 0.82, 1.22, 1.5, 1.8)  # of these numbers, which stand on a coarse grid
NODE = 0.1  # of a term's gain, that each of its nodes must be worth
N_LEADING = 3  # that are worth runs of their own


def leading_terms(drift: Drift, terms: Sequence[Candidate], least: float) -> list[Candidate]:
    """Return the terms that gain most beside a model.

    Parameters
    ----------
    drift : Drift
        The model.
    terms : sequence of Candidate
        Terms to choose from.
    least : float
        Log error that a term must gain.

    Returns
    -------
    list of Candidate
        Best first, each node taken for a tenth of the gain; one of those that differ in their
        numbers only, and none where no term gains so much.
    """
    near, gains = _near(drift, terms, n_replaced=0)
    worth = gains * (1.0 - NODE * np.array([c.size for c in near]))
    return _leaders(near, np.where(gains >= least, worth, -np.inf))


def stand_ins(
    drift: Drift, own: Candidate, terms: Sequence[Candidate], least: float
) -> list[Candidate]:
    """Return the terms that gain most in the place of an effect.

    Parameters
    ----------
    drift : Drift
        The model with the effect, which was the last to come.
    own : Candidate
        The effect, or all the terms of several.
    terms : sequence of Candidate
        Terms to choose from. Those in which nothing acts that acts in the effect are left out.
    least : float
        Log error that a term must gain, and at least the price of the nodes that it has more.

    Returns
    -------
    list of Candidate
        Best first, one of those that differ in their numbers only.
    """
    alike = [c for c in terms if c.state == own.state and own.variables & c.variables]
    others = [c for c in alike if c.terms != own.terms]
    near, gains = _near(drift, others, n_replaced=len(own.terms))
    prices = PRICE * np.array([c.size - own.size for c in near])
    return _leaders(near, gains - np.maximum(prices, least))


def _near(
    drift: Drift, terms: Sequence[Candidate], n_replaced: int
) -> tuple[list[Candidate], np.ndarray]:
    """Return the terms that do best on their grid, also with finer numbers, and what they gain."""
    able = with_parents(terms, drift.model.design)
    ranked = _of_families(able, _gains(drift, able, n_replaced))
    leaders = [c for c, _ in ranked[:N_FAMILIES]]
    near = [*leaders, *(_scaled(c, factor) for c in leaders for factor in FACTORS)]
    near = list(dict.fromkeys(near))
    return near, _gains(drift, near, n_replaced)


def _leaders(near: Sequence[Candidate], worth: np.ndarray) -> list[Candidate]:
    """Return the best few that are worth something."""
    return [c for c, value in _of_families(near, worth)[:N_LEADING] if value > 0.0]


def _gains(drift: Drift, terms: Sequence[Candidate], n_replaced: int) -> np.ndarray:
    """Return what each term gains in the place of the last columns, shape (n_terms,)."""
    groups = [columns_of(c, drift.model.design) for c in terms]
    return gains_of_terms(drift, groups, n_replaced)


def _of_families(terms: Sequence[Candidate], gains: np.ndarray) -> list[tuple[Candidate, float]]:
    """Return the best of the terms that differ in their numbers only, best first."""
    best: dict[Candidate, tuple[Candidate, float]] = {}
    for k in np.argsort(-gains, kind="stable").tolist():
        best.setdefault(_scaled(terms[k], None), (terms[k], float(gains[k])))
    return list(best.values())


def _scaled(candidate: Candidate, factor: float | None) -> Candidate:
    """Return a term with all its numbers times a factor, or all of them one."""
    terms = (
        term.with_constants([1.0 if factor is None else factor * c for c in term.constants])
        for term in candidate.terms
    )
    return replace(candidate, terms=tuple(terms))
