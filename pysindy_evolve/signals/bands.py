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

# Two measurements of one signal: largest power of their difference, over that of their noise.
AGREE = 10.0
LEAST_BINS, LEAST_WIDTH = 20, 0.07  # of a band: number of bins, and width over frequency
MAX_BANDS = 150  # where each is wider than the last by one factor
PASSED = 0.03  # share of the median power; a band below it was filtered away and shows no floor


def widening_edges(n: int) -> Bins:
    """Return the edges of bands whose width is a fixed share of their frequency, in any number."""
    edges = [0]
    while edges[-1] < n:
        edges.append(edges[-1] + max(LEAST_BINS, int(LEAST_WIDTH * edges[-1])))
    return np.array([*edges[:-2], n])  # the last band takes the remaining bins


def geometric_edges(n: int) -> Bins:
    """Return the edges of bands in a geometric series; the first, too narrow ones are one band."""
    edges = np.unique(np.geomspace(LEAST_BINS, n, MAX_BANDS).astype(np.intp))
    kept = edges[np.r_[True, np.diff(edges) >= LEAST_BINS]][:-1]
    return np.concatenate([[0], kept, [n]]).astype(np.intp)


def averaged(power: Array, edges: Bins) -> Array:
    """Return the mean power of each band; the bins are along the last axis."""
    return np.asarray(np.add.reduceat(power, edges[:-1], axis=-1) / np.diff(edges))


def lowest_quarter(power: Array, size: Bins) -> float:
    """Return the noise floor under the averaged powers of bands, whose sizes count bins.

    It is the lower quartile over the bins that were not filtered away: a signal only lifts a band.
    """
    order = np.argsort(power)
    count = np.cumsum(size[order])
    median = power[order][int(np.searchsorted(count, 0.5 * count[-1]))]
    order = order[power[order] > PASSED * median]
    count = np.cumsum(size[order])
    return float(power[order][int(np.searchsorted(count, 0.25 * count[-1]))])
