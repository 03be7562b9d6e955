"""Bands of frequencies, over which spectra are averaged before they are compared.

======  ============  ==========================================================
symbol  shape         meaning
======  ============  ==========================================================
edges   (n_bands+1,)  first bin of each band, and the number of bins
power   (n_bands,)    averaged power of each band
size    (n_bands,)    bins in each band
======  ============  ==========================================================
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .spectral import Array

Bins = NDArray[np.intp]

__all__ = ["AGREE", "Bins", "averaged", "geometric_edges", "lowest_quarter", "widening_edges"]

AGREE = 10.0  # times the power of their noise by which two measurements of one signal may differ
BINS, WIDER = 20, 0.07  # of a band: fewest bins, and least width as a share of its frequency
BANDS = 150  # at most, where they widen by the same factor each
PASSED = 0.03  # share of the median power below which a band was filtered away and is no floor


def widening_edges(n: int) -> Bins:
    """Return the edges of bands as wide as a share of their frequency, however many there are."""
    edges = [0]
    while edges[-1] < n:
        edges.append(edges[-1] + max(BINS, int(WIDER * edges[-1])))
    return np.array([*edges[:-2], n])  # the last one takes what is left


def geometric_edges(n: int) -> Bins:
    """Return the edges of bands that each are wider than the last by one factor, if not too few."""
    edges = np.unique(np.geomspace(BINS, n, BANDS).astype(np.intp))
    inner = edges[np.r_[True, np.diff(edges) >= BINS]][:-1]
    return np.concatenate([[0], inner, [n]]).astype(np.intp)


def averaged(power: Array, edges: Bins) -> Array:
    """Return the mean power of each band; the bins are along the last axis."""
    return np.asarray(np.add.reduceat(power, edges[:-1], axis=-1) / np.diff(edges))


def lowest_quarter(power: Array, size: Bins) -> float:
    """Return the floor under the averaged powers of bands of so many bins.

    The lowest quarter of the bins that were not filtered away, as a signal can only lift a band.
    """
    order = np.argsort(power)
    count = np.cumsum(size[order])
    median = power[order][int(np.searchsorted(count, 0.5 * count[-1]))]
    order = order[power[order] > PASSED * median]
    count = np.cumsum(size[order])
    return float(power[order][int(np.searchsorted(count, 0.25 * count[-1]))])
