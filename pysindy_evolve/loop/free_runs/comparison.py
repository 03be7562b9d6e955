"""Effects that could take each other's place, judged by free runs.

A filter turns the sign of a speed into something smoother, and blurs what two effects of similar
shape differ in. A model that runs by itself has no filter in it. So once all is found, each effect
has to hold its place against the few that come closest to it: all models are fitted to the same
stretches of the record by their runs, and another effect takes the place of one if its runs are
closer to the record by what matters, on so many stretches that chance hardly explains it.

References
----------
Vuong, Econometrica 57 (1989), DOI 10.2307/1912557: models not nested, compared piece by piece.
Wilcoxon, Biometrics Bull. 1 (1945), DOI 10.2307/3001968: the test of the signed ranks.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.stats import wilcoxon
from tqdm.auto import tqdm

from ...signals import Record
from ..effects.candidate import Candidate
from ..effects.missing import beside
from ..effects.names import EVOLVED
from ..effects.partners import shares_number
from ..effects.shaping import shape_of, with_units
from ..evidence.findings import Finding, excluding, is_needed, with_columns
from ..evidence.scoring import MARGIN, PRICE
from ..fitting.trial import Trial, converged
from ..given.rules import Rules
from .contenders import Pool, begun_with, steady_drift
from .shape_tuning import Contender
from .variants import Model

__all__ = ["held_against", "is_closer"]


def held_against(
    model: Model,
    findings: Sequence[Finding],
    pool: Pool,
    records: Sequence[Record],
    rules: Rules,
) -> list[Finding]:
    """Return findings in which effects hold their places, or have lost them to others.

    Parameters
    ----------
    model : Model
        The declared model, with the memories and limits among the findings.
    findings : sequence of Finding
        What was found.
    pool : Pool
        What may take a place.
    records : sequence of Record
        Training records, without memories.
    rules : Rules
        Significance.

    Returns
    -------
    list of Finding
        Their p-values stay: that something is missing there was tested before.
    """
    kept = list(findings)
    bar = tqdm(findings, desc="free runs", disable=not rules.progress, leave=False)
    for place, finding in enumerate(bar):
        rest = excluding(kept, finding)
        if finding.columns and not is_needed(finding, rest):
            without = replace(model, design=with_columns(model.design, rest))
            tied = any(shares_number(finding.candidate, f.candidate) for f in rest)
            kept[place] = _winner(without, finding, pool, records, rules, tied=tied)
    return kept


def _winner(
    model: Model,
    finding: Finding,
    pool: Pool,
    records: Sequence[Record],
    rules: Rules,
    *,
    tied: bool,
) -> Finding:
    """Return a finding, or the one that takes its place in a model without it."""
    own = finding.candidate
    drift = steady_drift(model, [own], records)
    if drift is None:
        return finding
    tuned = pool.contenders(model, Contender(own, drift.trial, tied), drift)
    best = _best(tuned, pool.matter, rules.significance / max(len(tuned) - 1, 1))
    plain = with_units(best.candidate)
    if plain is not None:  # sin(q), unless another number than one in it does clearly better
        (trial,) = converged([begun_with(model, [plain], drift)])
        best = Contender(plain, trial) if trial.error <= np.exp(pool.matter) * best.error else best
    return finding.with_candidate(beside(best.candidate, model.design), model.design)


def _best(tuned: Sequence[Contender], matter: float, level: float) -> Contender:
    """Return the first contender, or of those that do clearly better the one that does best."""
    own, *rivals = tuned
    closer = [
        other for other in rivals
        if is_closer(other.trial, own.trial, max(matter, _price(other, own)), level)
    ]  # fmt: skip
    best = min(closer, key=lambda one: one.error * np.exp(_price(one, own)), default=own)
    if not np.isfinite(best.error):  # nothing runs, so nothing does as well
        return own
    if best.candidate.name == EVOLVED:
        names = [one for one in tuned if one.candidate.name != EVOLVED]
        known = min(names, key=lambda one: one.error, default=best)
        if not is_closer(best.trial, known.trial, matter, level):
            best = known  # what engineers know by name, unless it does worse
    as_good = [one for one in tuned if one.error <= np.exp(MARGIN) * best.error]
    if best.candidate.name == EVOLVED:
        best = min([best, *as_good], key=lambda one: one.candidate.plainness)
    named = [one for one in as_good if one.candidate.name != EVOLVED]
    return min([best, *named], key=lambda one: _burden(one.candidate))


def _burden(candidate: Candidate) -> tuple[int, bool]:
    """Return how many numbers an effect has, and whether it is more than a straight line."""
    shape = shape_of(candidate)
    inside = 0 if shape is None else len(shape.values)
    return candidate.n_columns + inside, not candidate.is_straight


def _price(one: Contender, other: Contender) -> float:
    """Return what the nodes cost that a grown term has more than an effect."""
    longer = max(one.candidate.size - other.candidate.size, 0)
    return PRICE * longer if one.candidate.name == EVOLVED else 0.0


def is_closer(one: Trial, other: Trial, least: float, level: float) -> bool:
    """Tell whether the log error is less by so much, on more stretches than chance explains."""
    if not one.error < np.exp(-least) * other.error:  # so too where both are zero
        return False
    if not np.isfinite(other.error):  # its runs leave every number behind
        return True
    closer = _squares(other) - _squares(one)
    return bool(wilcoxon(closer, alternative="greater").pvalue <= level)


def _squares(trial: Trial) -> np.ndarray:
    """Return the squared error of each stretch, shape (n_stretches,)."""
    return np.asarray(np.sum((trial.miss / trial.scale) ** 2, axis=(1, 2)))
