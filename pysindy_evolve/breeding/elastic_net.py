"""The elastic net of one generation: which terms of its dictionary belong together.

It proposes supports beside those of earlier generations; pruning decides, see `sparse`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from ..sparse.beam import best_subsets, with_exchanges
from ..sparse.proposals import supports
from ..sparse.selection import Selection, select
from ..terms import Product
from .dictionary import Dictionary, price


def solve_elastic_net(
    dictionary: Dictionary,
    survivors: Sequence[Product],
    best: Sequence[Product],
    max_terms: int,
    *,
    smooth: bool,
) -> Selection:
    """Find the best equations that the dictionary holds: the best first, then smaller ones.

    The elastic net proposes supports; the survivors and the best equation so far are two more.
    Each is pruned by the information criterion. Terms of `smooth` operators look alike over a
    record: then small equations are searched as well, and also returned without one of their terms.
    """
    gram, terms = dictionary.gram, dictionary.terms
    known = {term: j for j, term in enumerate(terms)}
    old = [np.array([known[t] for t in ts if t in known], dtype=int) for ts in (survivors, best)]
    proposals = [*supports(gram, 2 * max_terms), *old]
    scaled = gram.scaled(gram.scale)
    found = select(
        gram,
        proposals,
        partial(price, terms),
        dictionary.residual,
        float(dictionary.y @ dictionary.y),
        max_terms,
        propose=partial(best_subsets, scaled, max_terms=max_terms) if smooth else None,
    )
    return replace(found, front=with_exchanges(found.front)) if smooth else found
