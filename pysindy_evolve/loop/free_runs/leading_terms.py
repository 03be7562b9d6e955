"""Terms that bring the runs of a model closest to the record, to first order.

A filter can make terms look alike. A search in the derivative then ranks them by chance, and may
not offer the right one at all. Where the present model lacks little, or holds a similar term
instead, its runs stay close to those of the right model, and a linearization about them shows what
each term would gain.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..effects.candidate import Candidate
from ..effects.missing import with_parents
from ..evidence.scoring import PRICE_PER_NODE_LOG, columns_of
from .drift import Drift, gains_of_terms

N_FAMILIES = 12  # families (terms equal but for their numbers) whose numbers are refined
FACTORS = (0.55, 0.67, 0.82, 1.22, 1.5, 1.8)  # tried on these numbers, which lie on a coarse grid
NODE = 0.1  # share of a term's gain that each of its nodes costs
N_LEADING = 3  # terms returned, which are then fitted by runs


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
        The best few by gain, less a tenth for each node; one of each family. Empty if no term gains
        `least`.
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
        The model with the effect as its last columns.
    own : Candidate
        The effect, or one with all the terms of several effects.
    terms : sequence of Candidate
        Terms to choose from. Those that share no variable with the effect are left out.
    least : float
        Log error that a term must gain; more if its additional nodes have a higher price.

    Returns
    -------
    list of Candidate
        The best few, best first; one of each family.
    """
    related = [c for c in terms if c.state == own.state and own.variables & c.variables]
    others = [c for c in related if c.terms != own.terms]
    near, gains = _near(drift, others, n_replaced=len(own.terms))
    prices = PRICE_PER_NODE_LOG * np.array([c.size - own.size for c in near])
    return _leaders(near, gains - np.maximum(prices, least))


def _near(
    drift: Drift, terms: Sequence[Candidate], n_replaced: int
) -> tuple[list[Candidate], np.ndarray]:
    """Return the best terms of the grid, also with their numbers scaled, and all their gains."""
    allowed = with_parents(terms, drift.model.design)
    ranked = _of_families(allowed, _gains(drift, allowed, n_replaced))
    leaders = [c for c, _ in ranked[:N_FAMILIES]]
    refined = [*leaders, *(_scaled(c, factor) for c in leaders for factor in FACTORS)]
    refined = list(dict.fromkeys(refined))
    return refined, _gains(drift, refined, n_replaced)


def _leaders(near: Sequence[Candidate], worth: np.ndarray) -> list[Candidate]:
    """Return the best few terms whose worth is positive."""
    return [c for c, value in _of_families(near, worth)[:N_LEADING] if value > 0.0]


def _gains(drift: Drift, terms: Sequence[Candidate], n_replaced: int) -> np.ndarray:
    """Return the gain of each term in place of the last columns, shape (n_terms,)."""
    groups = [columns_of(c, drift.model.design) for c in terms]
    return gains_of_terms(drift, groups, n_replaced)


def _of_families(terms: Sequence[Candidate], gains: np.ndarray) -> list[tuple[Candidate, float]]:
    """Return the best term of each family with its gain, best first."""
    best: dict[Candidate, tuple[Candidate, float]] = {}
    for k in np.argsort(-gains, kind="stable").tolist():
        best.setdefault(_scaled(terms[k], None), (terms[k], float(gains[k])))
    return list(best.values())


def _scaled(candidate: Candidate, factor: float | None) -> Candidate:
    """Return a term with its numbers multiplied by a factor, or set to one without a factor."""
    terms = (
        term.with_constants([1.0 if factor is None else factor * c for c in term.constants])
        for term in candidate.terms
    )
    return replace(candidate, terms=tuple(terms))
