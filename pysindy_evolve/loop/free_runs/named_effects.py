"""Find what a model lacks where only its free runs show it.

The derivative of a noisy record hides slow effects. An effect passes here if it brings the runs
over held-out stretches closer to the record than chance does in twins, and does not make the
derivative worse. In a closed loop the second condition matters: the input reacts to disturbances
of the output, so a memory that does not exist can improve the runs, but not the derivative.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...signals import Record
from ..evidence.findings import Finding, MemoryFinding, memories_in, next_step
from ..evidence.rejected import Rejected
from ..evidence.step import Look
from ..given.design import Design
from ..given.rules import Rules
from ..given.segments import segments
from .drift import Drift
from .judging import best_of, model_of, named_terms, rejection_of
from .state_limits import drift_from, needed, stops_of
from .variants import Model, Pasts, Variant, memories_beside


def find_by_runs(
    declared: Design,
    findings: Sequence[Finding],
    records: Sequence[Record],
    wide: Sequence[Record],
    rules: Rules,
    rng: np.random.Generator,
) -> tuple[Look, Pasts]:
    """Add the effects that free runs show, one after the other until none passes.

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
    rules : Rules
        When an effect counts.
    rng : numpy.random.Generator
        Draws the twins.

    Returns
    -------
    look : Look
        All findings; the numbers of the new memories are tuned again after each step.
    pasts : tuple of (tuple of float)
        For each record, the inputs before it began; empty if no memory depends on them.
    """
    before = list(findings)
    stops = stops_of(model_of(declared, before), records, rules, rng)
    new: list[Finding] = []
    pasts: Pasts = ()
    rejected: Rejected | None = None
    while len(before) + len(new) < rules.max_effects:
        model = replace(
            model_of(declared, [*before, *new]),
            limits=tuple(one.limit for one in stops),
            n_known=len(memories_in(before)),
            pasts=pasts,
        )
        drift = drift_from(model, records)
        if drift is None:
            break
        best = _memory_or_term(drift, wide, rules, rng, must_be_clear=not new)
        if best is None:
            break
        rejected = rejection_of(best[0], declared, drift, rules)
        if rejected is not None:
            break
        new, pasts = _retuned([*new, best[0]], best[1]), best[1].pasts
    whole = replace(model_of(declared, [*before, *new]), pasts=pasts)
    kept = needed(whole, stops, records, rules)
    memories = [f for f in new if isinstance(f, MemoryFinding)]
    terms = [f for f in new if f not in memories]
    number = next_step(before)
    found = (replace(f, step=number + k) for k, f in enumerate([*memories, *kept, *terms]))
    return Look((*before, *found), rejected), pasts


def _retuned(new: list[Finding], model: Model) -> list[Finding]:
    """Return findings with the tuned memories of a model."""
    memories = iter(model.memories[model.n_known :])
    return [replace(f, memory=next(memories)) if isinstance(f, MemoryFinding) else f for f in new]


def _memory_or_term(
    drift: Drift,
    wide: Sequence[Record],
    rules: Rules,
    rng: np.random.Generator,
    *,
    must_be_clear: bool,
) -> tuple[Finding, Model] | None:
    """Return the plainest memory or term of those that gain most, and the model with it."""
    memories = memories_beside(drift.model, segments(drift.records))
    terms = [v for v in named_terms(drift) if not must_be_clear or _is_of_motion(v, drift)]
    return best_of(drift, wide, terms, memories, rules, rng, must_be_clear=must_be_clear)


def _is_of_motion(variant: Variant, drift: Drift) -> bool:
    """Tell whether all parts of an effect depend on more than time.

    An offset or a drift may be a disturbance that outlasts a stretch. Twins do not imitate that, as
    each of their stretches has a sign of its own.
    """
    time = drift.model.design.time
    return all(term.variables - {time} for term in variant.candidate.terms)
