"""Find what a model lacks where only its free runs show it.

The derivative of a noisy record is blind to what is slow. What passes here keeps the runs on
stretches that it was not fitted to, better than chance does in the twins; and it must not make the
derivative worse. In a closed loop the input knows what disturbed the output, and runs can be
bettered by a memory that is not there; the derivative, which sees the disturbance itself, objects.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from ...signals import Record
from ..effects.candidate import Candidate
from ..effects.missing import candidates, with_parents
from ..evidence.findings import (
    Finding,
    MemoryFinding,
    limits_in,
    memories_in,
    next_step,
    with_columns,
)
from ..evidence.rejected import Rejected
from ..evidence.scoring import MARGIN, columns_of, score
from ..evidence.step import Look
from ..evidence.trace import Score
from ..fitting.fit import refit
from ..fitting.trial import settled
from ..given.design import Design
from ..given.limits import off_limits
from ..given.rules import Rules
from ..given.segments import ranges, segments, variables_of
from ..memories.reach import exchanged
from ..twins.chance import draws_for
from .drift import (
    LONG,
    Drift,
    chance_of_models,
    chance_of_terms,
    drift_of,
    gains_of_models,
    gains_of_terms,
)
from .leading_terms import leading_terms
from .memory_tuning import tuned_memories
from .state_limits import drift_from, needed, notable, stops_of
from .variants import Model, Pasts, Variant, memories_beside

__all__ = ["find_by_runs", "matters", "model_of", "share_of_miss"]


N_SIGNS = 999  # draws, which cost next to nothing
SQUARES_HALVED = float(np.log(2.0))  # of the squares that the runs miss


def find_by_runs(
    declared: Design,
    findings: Sequence[Finding],
    records: Sequence[Record],
    wide: Sequence[Record],
    small: Sequence[Candidate],
    rules: Rules,
    rng: np.random.Generator,
) -> tuple[Look, Pasts]:
    """Return findings with what free runs show besides, one after the other until none passes.

    Parameters
    ----------
    declared : Design
        The model at the start.
    findings : sequence of Finding
        What was found before.
    records : sequence of Record
        Training records without memories.
    wide : sequence of Record
        The same with a higher cutoff, for the derivative.
    small : sequence of Candidate
        Terms without a name that may be it, besides the vocabulary.
    rules : Rules
        When an effect counts.
    rng : numpy.random.Generator
        Draws the twins.

    Returns
    -------
    look : Look
        All findings; the numbers of the new memories are tuned again after each step.
    pasts : tuple of (tuple of float)
        For each record, where its inputs stood before it; empty where that does not matter.
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
        best = _memory_or_term(drift, wide, not new, small, rules, rng)
        if best is None:
            break
        finding, share = best[0], share_of_miss(best[0], declared, drift)
        if finding.p_value > rules.level_of_runs or not matters(finding, share, rules):
            rejected = _as_rejected(finding, share, drift, rules.level_of_runs)
            break
        new, pasts = _retuned([*new, finding], best[1]), best[1].pasts
    whole = replace(model_of(declared, [*before, *new]), pasts=pasts)
    kept = needed(whole, stops, records, rules)
    memories = [f for f in new if isinstance(f, MemoryFinding)]
    terms = [f for f in new if f not in memories]
    number = next_step(before)
    found = (replace(f, step=number + k) for k, f in enumerate([*memories, *kept, *terms]))
    return Look((*before, *found), rejected), pasts


def model_of(declared: Design, findings: Sequence[Finding]) -> Model:
    """Return a design with all findings, memories and limits among them."""
    return Model(with_columns(declared, findings), memories_in(findings), limits_in(findings))


def _retuned(new: list[Finding], model: Model) -> list[Finding]:
    """Return findings with the memories of a model."""
    memories = iter(model.memories[model.n_known :])
    return [replace(f, memory=next(memories)) if isinstance(f, MemoryFinding) else f for f in new]


def matters(finding: Finding, share: float, rules: Rules) -> bool:
    """Tell whether a finding is more than a trace, or halves the squares that are left."""
    return finding.score >= SQUARES_HALVED or share >= rules.min_share


def _memory_or_term(
    drift: Drift,
    wide: Sequence[Record],
    first: bool,
    small: Sequence[Candidate],
    rules: Rules,
    rng: np.random.Generator,
) -> tuple[Finding, Model] | None:
    """Return the plainest memory or term of those that gain most, with its chance.

    Of memories that differ in numbers only, the best one of a grid is tested, as in the twins, and
    those that pass are tuned. A term without a name is looked at where it gains notably more than
    all that have one.
    """
    n_signs, least = draws_for(rules.level_of_runs, N_SIGNS), notable(rules)
    signs = rng.choice([-1.0, 1.0], size=(n_signs, len(drift.part.z)))
    memories = memories_beside(drift.model, drift.records, segments(drift.records))
    terms = [v for v in _terms(drift) if not first or _is_of_motion(v, drift)]
    by_terms = gains_of_terms(drift, [v.columns for v in terms])
    best_named = max(0.0, by_terms.max(initial=0.0))
    leading = _variants(drift, leading_terms(drift, small, best_named + least))
    terms += leading
    by_terms = np.append(by_terms, gains_of_terms(drift, [v.columns for v in leading]))
    # Nothing is held against the twins where no term gains enough.
    sought = [v.columns for v in terms] if np.any(by_terms >= least) else []
    sought += [columns_of(c, drift.model.design) for c in small] if leading else []
    in_twins = chance_of_terms(drift, sought, signs)
    plain = np.append(by_terms, gains_of_models(drift, [v.model for v in memories])[0])
    heads = _heads([*terms, *memories], plain, least)
    heads = [(k, variant) for k, variant in heads if not _refuted(drift, wide, variant)]
    if not heads:
        return None
    beside = [v for _, v in heads if first and v.memory is None]
    twins = chance_of_models(drift, [v.model for v in (*memories, *beside)], signs)
    twins[0] = np.maximum(twins[0], in_twins)
    judged = _judged(drift, [v for _, v in heads], plain[[k for k, _ in heads]], twins, first)
    passing = [one for one in judged if one[2] <= rules.level_of_runs]
    variant, gain, p_value = _plainest(drift, passing) if passing else judged[0]
    own = (variant.candidate, variant.columns, gain, p_value, twins[0])
    if variant.memory is not None:
        return MemoryFinding(*own, by_runs=True, memory=variant.memory), variant.model
    return Finding(*own, by_runs=True), variant.model


def _judged(
    drift: Drift, heads: Sequence[Variant], gains: np.ndarray, twins: np.ndarray, first: bool
) -> list[tuple[Variant, float, float]]:
    """Return variants with their gains and chances.

    What is new must show them as well: what an input answers to may look like a memory. Only a term
    beside what is slow shows in nothing but the whole miss.
    """
    views = gains_of_models(drift, [variant.model for variant in heads])
    views[0] = gains
    views[1, [variant.memory is None and not first for variant in heads]] = np.inf
    chances = [_p_value(view, twins) for view in views.T]
    return list(zip(heads, gains.tolist(), chances, strict=True))


def _is_of_motion(variant: Variant, drift: Drift) -> bool:
    """Tell whether a term depends on what was measured, as chance in the twins does not.

    What lasts for longer than a stretch, such as an offset or a drift, is there by chance as well.
    """
    time = len(drift.model.design.states) + len(drift.model.design.inputs)
    return all(term.variables - {time} for term in variant.candidate.terms)


def _p_value(gain: np.ndarray, twins: np.ndarray) -> float:
    """Return the chance of a gain in the view that is less sure of it."""
    n_better = np.sum(twins >= gain[:, None], axis=1)
    return float(np.max(1 + n_better)) / (1 + twins.shape[1])


def _heads(
    tried: Sequence[Variant], gains: np.ndarray, notable: float
) -> list[tuple[int, Variant]]:
    """Return the best of each family that gains at least half as much as the best of all."""
    found: dict[tuple[object, ...], int] = {}
    for k in np.argsort(-gains).tolist():
        if gains[k] >= max(notable, 0.5 * gains.max()):
            found.setdefault(tried[k].family, k)
    return [(k, tried[k]) for k in found.values()]


def _plainest(
    drift: Drift, passing: Sequence[tuple[Variant, float, float]]
) -> tuple[Variant, float, float]:
    """Tune variants on long runs, and return the plainest of those that do as well as the best."""
    long = drift_of(drift.model, drift.trial.coef, drift.records, LONG) or drift
    variants = [one[0].with_model(tuned_memories(long, one[0].model)) for one in passing]
    gains = gains_of_models(long, [variant.model for variant in variants])[0]
    near = gains >= gains.max() - max(MARGIN, 0.01 * gains.max())
    k = min(np.flatnonzero(near).tolist(), key=lambda k: variants[k].plainness)
    return variants[k], passing[k][1], passing[k][2]


def share_of_miss(finding: Finding, declared: Design, drift: Drift) -> float:
    """Return what share of the squares that the declared model's runs miss a finding removes.

    As in the look at names, a memory is held against what the present model leaves: it makes no
    equation longer.
    """
    removed = float(-np.expm1(-finding.score))
    if isinstance(finding, MemoryFinding) or not declared.columns:
        return removed
    coef = refit(declared, drift.records, "derivative")
    trial = Model(declared).trial(coef, drift.trial.scale, drift.records, drift.part)
    (first,) = settled([trial])
    if not np.isfinite(first.error):  # nothing to be compared with
        return removed
    return removed * min(drift.trial.error / max(first.error, 1e-300), 1.0)


def _as_rejected(finding: Finding, share: float, drift: Drift, level: float) -> Rejected:
    design = drift.model.design
    left = np.full(1, np.exp(-finding.score))
    tried = Score((finding.candidate,), (), np.ones(1), left, finding.score)
    names = (*design.states, *design.inputs, "t")
    return Rejected(tried, share, finding.p_value, finding.twin_scores, names, level)


def _terms(drift: Drift) -> list[Variant]:
    """Return the effects of the vocabulary that may enter."""
    design = drift.model.design
    acted = drift.model.acted(drift.records)
    variables = np.concatenate([variables_of(record) for record in acted])
    return _variants(drift, with_parents(candidates(design, *ranges(variables)), design))


def _variants(drift: Drift, terms: Iterable[Candidate]) -> list[Variant]:
    """Return the present model with each of the terms in it."""
    design, found = drift.model.design, []
    for candidate in terms:
        columns = columns_of(candidate, design)
        wider = replace(drift.model, design=design.adding(columns))
        found.append(Variant(candidate, wider, columns))
    return found


def _refuted(drift: Drift, wide: Sequence[Record], variant: Variant) -> bool:
    """Tell whether the derivative is predicted worse with a variant than without it."""
    design = drift.model.design
    acted = drift.model.acted(wide)
    part = off_limits(segments(acted, design.velocities), drift.model.limits)
    if variant.memory is not None:
        gain = exchanged([variant.memory], design, acted, part)[0].gain
    elif variant.columns:
        scores = score(design, part, [replace(variant.candidate, parents=())], pairs=False)
        gain = scores[0].value if scores else 0.0
    else:
        gain = 0.0
    return gain < -MARGIN
