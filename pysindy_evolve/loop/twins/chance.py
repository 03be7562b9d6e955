"""The p-value of a statistic, from its values where nothing is missing.

References
----------
Phipson and Smyth, Stat. Appl. Genet. Mol. Biol. 9 (2010), DOI 10.2202/1544-6115.1585: p-values are
never zero.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

__all__ = ["draws_for", "p_value_of"]


def p_value_of(observed: float, values: np.ndarray | Sequence[float]) -> float:
    """Return (1 + number of values at least as large) / (1 + number of values)."""
    return float((1 + np.sum(np.asarray(values) >= observed)) / (1 + len(values)))


def draws_for(level: float, usual: int) -> int:
    """Return how many values a p-value as small as a level takes: the usual number, or more.

    The smallest p-value of n values is 1 / (n + 1).
    """
    return max(usual, int(np.ceil(1.0 / level - 1e-9)) - 1)
