"""How much free runs gain from variants of a model, and whether that is more than chance.

A variant counts if it predicts held-out stretches better than variants do in twins, if the gain
matters, and if it does not make the derivative worse.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from ...checks import TINY
from ...signals import Record
from ..effects.candidate import Candidate
from ..effects.missing import candidates, with_parents
from ..evidence.findings import Finding, MemoryFinding, limits_in, memories_in, with_columns
from ..evidence.plainest import as_good_as_best
from ..evidence.ranking import Score
from ..evidence.rejected import Rejected
from ..evidence.scoring import MIN_GAIN_LOG, columns_of, score
from ..fitting.fit import refit
from ..fitting.trial import converged
from ..given.design import Design
from ..given.limits import off_limits
from ..given.ranges import Ranges
from ..given.rows import rows_of
from ..given.rules import Rules
from ..given.segments import segments
from ..given.sticking import may_rest, noise_of
from ..memories.length_and_kind import exchanged
from ..twins.chance import draws_for, p_value_of
from .drift import (
    N_LONG_STRETCHES,
    Drift,
    chance_of_models,
    chance_of_terms,
    drift_of,
    gains_of_models,
    gains_of_terms,
)
from .memory_tuning import tuned_memories
from .variants import Model, Variant

N_SIGNS = 999  # draws of signs, which cost next to nothing

SQUARES_HALVED = float(np.log(2.0))  # gain in log error that halves the squared misses
# Squared misses over squared sensor noise; below, noise is a good part of them.
MAX_SQUARES_OVER_NOISE = 3.0

Judged = tuple[Variant, float, float]  # a variant, its log gain, and its p-value


def model_of(declared: Design, findings: Sequence[Finding]) -> Model:
    """Return the model of a design with all findings, memories and limits included."""
    return Model(with_columns(declared, findings), memories_in(findings), limits_in(findings))


def _signs_for(drift: Drift, rules: Rules, rng: np.random.Generator) -> np.ndarray:
    """Draw signs for the stretches of twins, (n_draws, n_stretches); enough for the level."""
    n_draws = draws_for(rules.level_of_runs, N_SIGNS)
    return rng.choice([-1.0, 1.0], size=(n_draws, len(drift.part.z)))


def rejection_of(finding: Finding, declared: Design, drift: Drift, rules: Rules) -> Rejected | None:
    """Return the report's entry for a finding that does not pass; None if it passes."""
    share = share_of_miss(finding, declared, drift)
    if finding.p_value <= rules.level_of_runs and matters(finding, share, rules):
        return None
    return _as_rejected(finding, share, drift, rules.level_of_runs)


def matters(finding: Finding, share: float, rules: Rules) -> bool:
    """Tell whether a finding halves the squared misses, or removes a share that matters."""
    return finding.score >= SQUARES_HALVED or share >= rules.min_share


def share_of_miss(finding: Finding, declared: Design, drift: Drift) -> float:
    """Return the share of the declared model's squared misses that a finding removes.

    For a memory, it is the share of the present model's misses, as in the search for names: a
    memory makes no equation longer.
    """
    removed = float(-np.expm1(-finding.score))
    if isinstance(finding, MemoryFinding) or not declared.columns:
        return removed
    coef = refit(declared, drift.records, "derivative")
    trial = Model(declared).trial(coef, drift.trial.scale, drift.part)
    (first,) = converged([trial])
    if not np.isfinite(first.error):  # the declared model cannot be run
        return removed
    return removed * min(drift.trial.error / max(first.error, TINY), 1.0)


def named_terms(drift: Drift) -> list[Variant]:
    """Return the present model with each of the vocabulary's effects that may enter."""
    design = drift.model.design
    ranges = Ranges.of(rows_of(drift.model.acted(drift.records)))
    return variants_of(drift, with_parents(candidates(design, ranges), design))


def variants_of(drift: Drift, terms: Iterable[Candidate]) -> list[Variant]:
    """Return the present model with each of the terms in it."""
    design, found = drift.model.design, []
    for candidate in terms:
        columns = columns_of(candidate, design)
        wider = replace(drift.model, design=design.adding(columns))
        found.append(Variant(candidate, wider, columns))
    return found


def best_of(
    drift: Drift,
    wide: Sequence[Record],
    terms: Sequence[Variant],
    memories: Sequence[Variant],
    rules: Rules,
    rng: np.random.Generator,
    *,
    must_be_clear: bool,
    also_searched: Sequence[Candidate] = (),
) -> tuple[Finding, Model] | None:
    """Return the plainest of the variants that gain most, with its p-value.

    Parameters
    ----------
    drift : Drift
        The present model.
    wide : sequence of Record
        Training records with a higher cutoff, to check the derivative.
    terms, memories : sequence of Variant
        All variants. Of those that differ only in numbers the best is tested, in the twins too;
        variants that pass are tuned.
    rules : Rules
        When an effect counts.
    rng : numpy.random.Generator
        Draws the signs of the twins' misses.
    must_be_clear : bool
        Whether a term must halve the squared misses, or leave little more than noise, and must also
        gain on the whitened misses.
    also_searched : sequence of Candidate
        Terms that have been left out by now; twins are searched for them as well.

    Returns
    -------
    tuple of Finding and Model, or None
        None if nothing gains notably. The caller decides whether the p-value is small enough.
    """
    signs = _signs_for(drift, rules, rng)
    by_terms = gains_of_terms(drift, [v.columns for v in terms])
    by_memories = gains_of_models(drift, [v.model for v in memories])[0]
    tried, gains = [*terms, *memories], np.append(by_terms, by_memories)
    heads = _heads(tried, gains, rules.notable_gain)
    heads = [(v, gain) for v, gain in heads if not _is_refuted(drift, wide, v)]
    if must_be_clear:
        heads = [(v, gain) for v, gain in heads if v.memory is not None or _is_clear(drift, gain)]
    if not heads:
        return None
    models = [v.model for v in memories]
    models += [v.model for v, _ in heads if must_be_clear and v.memory is None]
    twins = chance_of_models(drift, models, signs)
    # Twins need not be searched for terms where no term gains enough on the record.
    if np.any(by_terms >= rules.notable_gain):
        left_out = [columns_of(one, drift.model.design) for one in also_searched]
        in_twins = chance_of_terms(drift, [*(v.columns for v in terms), *left_out], signs)
        twins[0] = np.maximum(twins[0], in_twins)
    judged = _judged(drift, heads, twins, must_be_clear=must_be_clear)
    passing = [entry for entry in judged if entry[2] <= rules.level_of_runs]
    variant, gain, p_value = _plainest(drift, passing) if passing else judged[0]
    return _as_finding(variant, gain, p_value, twins[0]), variant.model


def _as_finding(variant: Variant, gain: float, p_value: float, twins: np.ndarray) -> Finding:
    """Return what a variant has more than the present model, with its evidence."""
    found = variant.candidate, variant.columns, gain, p_value, twins
    if variant.memory is None:
        return Finding(*found, by_runs=True)
    return MemoryFinding(*found, by_runs=True, memory=variant.memory)


def _heads(
    tried: Sequence[Variant], gains: np.ndarray, least: float
) -> list[tuple[Variant, float]]:
    """Return the best variant of each family, with its gain, if that is half of the best of all."""
    found: dict[tuple[object, ...], int] = {}
    for k in np.argsort(-gains).tolist():
        if gains[k] >= max(least, 0.5 * gains.max()):
            found.setdefault(tried[k].family, k)
    return [(tried[k], float(gains[k])) for k in found.values()]


def _is_refuted(drift: Drift, wide: Sequence[Record], variant: Variant) -> bool:
    """Tell whether a variant makes the prediction of the derivative worse."""
    design = drift.model.design
    acted = drift.model.acted(wide)
    part = off_limits(segments(acted, may_rest(design, acted)), drift.model.limits)
    if variant.memory is not None:
        gain = exchanged([variant.memory], design, part)[0].gain
    elif variant.columns:
        scores = score(design, part, [replace(variant.candidate, parents=())], pairs=False)
        gain = scores[0].value if scores else 0.0
    else:
        gain = 0.0
    return gain < -MIN_GAIN_LOG


def _is_clear(drift: Drift, gain: float) -> bool:
    """Tell whether a term halves the squared misses, or leaves little more than sensor noise.

    Where an unmeasured force drives the runs away from the record, and an input reacts to it, terms
    of the motion can imitate that force.
    """
    return gain >= SQUARES_HALVED or over_noise(drift) * np.exp(-gain) <= MAX_SQUARES_OVER_NOISE


def over_noise(drift: Drift) -> float:
    """Return the mean squared miss of measured states, over the variance of sensor noise."""
    made = drift.records[0].preparation
    states = range(0, drift.left.shape[-1], 1 if made is None else made.order)
    noise = np.array([[noise_of(record, state) for state in states] for record in drift.records])
    if np.any(noise == 0.0):  # unknown
        return np.inf
    missed = np.mean(drift.left[..., list(states)] ** 2, axis=(0, 1))
    return float(np.mean(missed / np.mean(noise**2, axis=0)))


def _judged(
    drift: Drift,
    heads: Sequence[tuple[Variant, float]],
    twins: np.ndarray,
    *,
    must_be_clear: bool,
) -> list[Judged]:
    """Return variants with their gains and p-values.

    A variant must also gain on whitened misses, since feedback can imitate it in the plain ones.
    Terms are exempt where they need not be clear.
    """
    variants, gains = zip(*heads, strict=True)
    views = gains_of_models(drift, [variant.model for variant in variants])
    views[0] = gains
    views[1, [variant.memory is None and not must_be_clear for variant in variants]] = np.inf
    p_values = [max(map(p_value_of, view, twins)) for view in views.T]  # the larger of both views
    return list(zip(variants, gains, p_values, strict=True))


def _plainest(drift: Drift, passing: Sequence[Judged]) -> Judged:
    """Tune variants on long runs, and return the plainest of those as good as the best."""
    long = drift_of(drift.model, drift.trial.coef, drift.records, N_LONG_STRETCHES) or drift
    variants = [one[0].with_model(tuned_memories(long, one[0].model)) for one in passing]
    gains = gains_of_models(long, [variant.model for variant in variants])[0]
    k = min(as_good_as_best(gains), key=lambda k: variants[k].plainness)
    return variants[k], passing[k][1], passing[k][2]


def _as_rejected(finding: Finding, share: float, drift: Drift, level: float) -> Rejected:
    """Return a finding that did not pass, for the report."""
    design = drift.model.design
    error_ratio = np.full(1, np.exp(-finding.score))
    tried = Score((finding.candidate,), (), np.ones(1), error_ratio, finding.score)
    return Rejected(tried, share, finding.p_value, finding.twin_scores, design.names, level)
