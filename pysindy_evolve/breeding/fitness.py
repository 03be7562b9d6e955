"""Fitness of the terms of one generation: how badly each serves, lower is better."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..sparse.elimination import gains
from .dictionary import Dictionary, price

__all__ = ["rate"]


def rate(
    dictionary: Dictionary, front: Sequence[np.ndarray], n_effective: float
) -> tuple[np.ndarray, np.ndarray]:
    """Fitness of each term, lower is better, and the equation it goes best with.

    It is the mean square error of the best equation that has the term in it, put as information
    criterion n log(MSE) + price. Small equations are tried as well as the best one, because a
    term that says at once what ten others say together adds nothing to the ten.
    """
    gram = dictionary.gram.scaled(dictionary.gram.scale)
    cost = price(dictionary.terms, n_effective)
    value = np.empty((len(front), len(cost)))
    for row, support in zip(value, front, strict=True):
        with_term, _ = gains(gram, support)
        row[:] = n_effective * np.log(with_term / gram.n) + cost[support].sum() + cost
        row[support] -= cost[support]
    return value.min(axis=0), value.argmin(axis=0)
