"""Find terms without a name that only free runs show.

This look comes last. What the derivative shows has been grown from it before; here the runs only
decide which of some small terms comes closest to what is missing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...signals import Record
from ..effects.candidate import Candidate
from ..evidence.findings import Finding, memories_in, next_step
from ..evidence.step import Look
from ..given.design import Design
from ..given.rules import Rules
from .drift import Drift, gains_of_terms
from .judging import best_of, model_of, named_terms, rejection_of, variants_of
from .leading_terms import leading_terms
from .state_limits import drift_from


def find_unnamed(
    declared: Design,
    findings: Sequence[Finding],
    records: Sequence[Record],
    wide: Sequence[Record],
    small: Sequence[Candidate],
    rules: Rules,
    rng: np.random.Generator,
) -> Look:
    """Add the small terms that free runs show, one after the other until none passes.

    Parameters
    ----------
    declared : Design
        The declared model.
    findings : sequence of Finding
        What was found before.
    records : sequence of Record
        Training records, before memories are applied.
    wide : sequence of Record
        The same with a higher cutoff, to check the derivative.
    small : sequence of Candidate
        Terms to try.
    rules : Rules
        When an effect counts.
    rng : numpy.random.Generator
        Draws the twins.

    Returns
    -------
    Look
        All findings.
    """
    found, rejected = list(findings), None
    while len(found) < rules.max_effects:
        model = replace(model_of(declared, found), n_known=len(memories_in(found)))
        drift = drift_from(model, records)
        finding = None if drift is None else _leading(drift, wide, small, rules, rng)
        if drift is None or finding is None:
            break
        rejected = rejection_of(finding, declared, drift, rules)
        if rejected is not None:
            break
        found.append(replace(finding, step=next_step(found)))
    return Look(tuple(found), rejected)


def _leading(
    drift: Drift,
    wide: Sequence[Record],
    small: Sequence[Candidate],
    rules: Rules,
    rng: np.random.Generator,
) -> Finding | None:
    """Return the plainest of the small terms that gain notably more than every named effect."""
    named = gains_of_terms(drift, [v.columns for v in named_terms(drift)])
    least = rules.notable_gain + max(0.0, named.max(initial=0.0))
    terms = variants_of(drift, leading_terms(drift, small, least))
    if not terms:
        return None
    best = best_of(drift, wide, terms, [], rules, rng, must_be_clear=True, also_searched=small)
    return None if best is None else best[0]
