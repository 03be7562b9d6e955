"""Fitness of the terms of one generation; lower is better."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..sparse.elimination import gains
from .dictionary import Dictionary, price


def rate_terms(
    dictionary: Dictionary, front: Sequence[np.ndarray], n_effective: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return the fitness of each term, and the index of the equation in which it serves best.

    The fitness is the information criterion n log(MSE) + price of the best equation with the term
    in it, lower is better. Small equations are tried too: a term that replaces ten others adds
    nothing to an equation that holds the ten.
    """
    gram = dictionary.gram.scaled(dictionary.gram.scale)
    cost = price(dictionary.terms, n_effective)
    value = np.empty((len(front), len(cost)))
    for row, support in zip(value, front, strict=True):
        with_term, _ = gains(gram, support)
        row[:] = n_effective * np.log(with_term / gram.n) + cost[support].sum() + cost
        row[support] -= cost[support]
    return value.min(axis=0), value.argmin(axis=0)
