"""Best small subsets of nearly collinear columns by beam search; symbols as in `gram`.

Over the range of a record, smooth terms are nearly collinear. The elastic net, like any greedy
path, then goes through combinations of wrong terms and misses the right few. To find these, a beam
search keeps several supports of each size and exchanges single terms in the best one.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .elimination import gains
from .gram import Gram

WIDTH = 8  # supports of each size that are kept
MAX_SIZE = 6  # terms; larger equations are left to the elastic net


def best_subsets(
    gram: Gram, penalty: np.ndarray, n_effective: float, max_terms: int
) -> list[np.ndarray]:
    """Propose the best supports of one term, of two, and so on.

    Parameters
    ----------
    gram : Gram
        Inner products; columns should have similar sizes.
    penalty : ndarray of shape (p,)
        Price of each column, in units of `information`.
    n_effective : float
        Number of independent rows.
    max_terms : int
        Size of the largest support.

    Returns
    -------
    list of ndarray of int

    Notes
    -----
    Costs WIDTH p k^2 for each size k, plus p k^3 for the exchanges.
    """
    found: list[np.ndarray] = []
    beam: dict[tuple[int, ...], float] = {(): 0.0}
    for _ in range(min(max_terms, MAX_SIZE, len(gram.xy))):
        children: dict[tuple[int, ...], float] = {}
        for support in beam:
            value = _values(gram, support, penalty, n_effective)
            for j in np.argsort(value, kind="stable")[:WIDTH]:
                if np.isfinite(value[j]):
                    children[tuple(sorted((*support, int(j))))] = float(value[j])
        if not children:
            break
        best = min(children, key=lambda s: children[s])
        better = _exchanged(gram, best, penalty, n_effective, children[best])
        children |= better
        kept = sorted(children, key=lambda s: children[s])[:WIDTH]
        beam = {support: children[support] for support in kept}
        found.append(np.array(kept[0]))
    return found


def with_exchanges(front: Sequence[np.ndarray]) -> list[np.ndarray]:
    """Add to a front the supports with one term left out.

    A new term shows its gain, and can be tuned, only where the term that it replaces is missing.

    Parameters
    ----------
    front : sequence of ndarray of int
        Supports, the best first.

    Returns
    -------
    list of ndarray of int
        Without duplicates; the best and the small supports also with each term left out.
    """
    found = {frozenset(support.tolist()): support for support in front}
    for i, support in enumerate(front):
        if i == 0 or len(support) <= MAX_SIZE:
            for j in range(len(support)):
                rest = np.delete(support, j)
                found.setdefault(frozenset(rest.tolist()), rest)
    return list(found.values())


def _values(
    gram: Gram, support: tuple[int, ...], penalty: np.ndarray, n_effective: float
) -> np.ndarray:
    """Information criterion of a support with each other column: (p,)."""
    with_column, _ = gains(gram, support)
    value = n_effective * np.log(with_column / gram.n) + penalty + penalty[list(support)].sum()
    value[list(support)] = np.inf
    return value


def _exchanged(
    gram: Gram, support: tuple[int, ...], penalty: np.ndarray, n_effective: float, value: float
) -> dict[tuple[int, ...], float]:
    """Exchange one term at a time for a better one, until no better one is left."""
    better: dict[tuple[int, ...], float] = {}
    for _ in range(len(support)):
        children = {}
        for i in range(len(support)):
            rest = support[:i] + support[i + 1 :]
            values = _values(gram, rest, penalty, n_effective)
            j = int(np.argmin(values))
            children[tuple(sorted((*rest, j)))] = float(values[j])
        best = min(children, key=lambda s: children[s])
        if children[best] >= value - 1e-9:
            break
        support, value = best, children[best]
        better[support] = value
    return better
