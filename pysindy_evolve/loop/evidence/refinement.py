"""Whether an effect is more than a plainer one seen through noise.

Even where plain friction is the cause, a friction whose sign changes early or late fits a noisy
record a little better: the filtered velocity turns late, and a lead makes up for it. So an effect
that refines a plainer one must lead it by more than in twins of the plainer one, with the same
sensor noise.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np

from ..effects.candidate import Candidate
from ..given.design import Design
from ..given.rules import Rules
from ..given.segments import Segments
from ..twins.chance import chance_on_twins
from ..twins.twins import TwinMaker
from .scoring import MIN_GAIN_LOG, columns_of, quick_fit, score


def justified(
    candidate: Candidate,
    design: Design,
    proposed: Sequence[Candidate],
    part: Segments,
    rules: Rules,
    rng: np.random.Generator,
) -> Candidate:
    """Return a candidate, or the plainer one that it refines if its lead may be chance.

    Parameters
    ----------
    candidate : Candidate
        What passed.
    design : Design
        The model without it.
    proposed : sequence of Candidate
        All candidates of the look.
    part : Segments
        Pieces of the training records.
    rules : Rules
        Significance and twins.
    rng : numpy.random.Generator
        Draws the twins.

    Returns
    -------
    Candidate
    """
    n_partners = len(candidate.partners)
    same_equation = [
        c for c in proposed if c.state == candidate.state and len(c.partners) == n_partners
    ]
    forms = [c for c in same_equation if c.name == candidate.name]
    plain = score(
        design, part, [c for c in same_equation if c.name in candidate.must_beat], pairs=False
    )
    if not plain or part.by_trajectory:
        return candidate
    (null,) = plain[0].group
    equations = quick_fit(design.adding(columns_of(null, design)), part)
    lead = partial(_lead, design=design, forms=forms, plain=[s.group[0] for s in plain])
    observed = lead(part)
    if observed < MIN_GAIN_LOG:
        return null
    maker = TwinMaker.of(equations, part.records)
    p_value = chance_on_twins(maker, part, lead, observed, rules, rng)[0]
    return candidate if p_value <= rules.level else null


def _lead(
    part: Segments, *, design: Design, forms: Sequence[Candidate], plain: Sequence[Candidate]
) -> float:
    """Return by how much the best form scores more than the best plain one."""
    scores = score(design, part, [*forms, *plain], pairs=False)
    best = {c: s.value for s in reversed(scores) for c in s.group}
    return max((best[c] for c in forms if c in best), default=0.0) - max(
        (best[c] for c in plain if c in best), default=0.0
    )
