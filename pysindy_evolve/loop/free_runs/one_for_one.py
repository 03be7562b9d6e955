"""Effects that could replace each other, compared by free runs.

A filter smooths the sign of a speed, and blurs the difference between effects of similar shape. A
free run contains no filter. So once the search has ended, each effect has to hold its place against
the few that come closest to it. All models are fitted to the same stretches of the record by their
free runs. Another effect replaces the present one if its runs are closer to the record by a margin
that matters, and on more stretches than chance explains.

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
from ..evidence.plainest import is_as_good
from ..evidence.scoring import PRICE_PER_NODE_LOG
from ..fitting.trial import Trial, converged
from ..given.rules import Rules
from .contenders import Pool, steady_drift, trial_with
from .shape_tuning import Contender
from .variants import Model


def exchanged_by_runs(
    model: Model, findings: Sequence[Finding], pool: Pool, records: Sequence[Record], rules: Rules
) -> list[Finding]:
    """Return the findings, each effect replaced where another one comes closer to the record.

    Parameters
    ----------
    model : Model
        The declared model, with the memories and limits among the findings.
    findings : sequence of Finding
        What was found.
    pool : Pool
        Candidates that may replace an effect.
    records : sequence of Record
        Training records, before memories are applied.
    rules : Rules
        Gives the significance.

    Returns
    -------
    list of Finding
        They keep their p-values: that an effect is missing there was tested before.
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
    """Return the finding, or its replacement, in a model that holds neither."""
    present = finding.candidate
    drift = steady_drift(model, [present], records)
    if drift is None:
        return finding
    tuned = pool.contenders(model, Contender(present, drift.trial, tied), drift)
    best = best_of(tuned, pool.matter, rules.significance / max(len(tuned) - 1, 1))
    plain = with_units(best.candidate)
    if plain is not None:  # sin(q) replaces sin(0.99 q), unless that does clearly better
        (trial,) = converged([trial_with(model, [plain], drift)])
        best = Contender(plain, trial) if trial.error <= np.exp(pool.matter) * best.error else best
    return finding.with_candidate(beside(best.candidate, model.design), model.design)


def best_of(tuned: Sequence[Contender], matter: float, level: float) -> Contender:
    """Return the first contender, or the best of those that are clearly closer to the record.

    A grown term must also be clearly closer than the best named effect. Among contenders as good as
    the best, plainer ones and names are preferred.
    """
    present, *rivals = tuned
    closer = [
        other for other in rivals
        if is_closer(other.trial, present.trial, max(matter, _price(other, present)), level)
    ]  # fmt: skip
    best = min(closer, key=lambda one: one.error * np.exp(_price(one, present)), default=present)
    if not np.isfinite(best.error):  # no model can be run
        return present
    if best.candidate.name == EVOLVED:
        names = [one for one in tuned if one.candidate.name != EVOLVED]
        best_named = min(names, key=lambda one: one.error, default=best)
        if not is_closer(best.trial, best_named.trial, matter, level):
            best = best_named
    as_good = [one for one in tuned if is_as_good(one.error, best.error)]
    if best.candidate.name == EVOLVED:
        best = min([best, *as_good], key=lambda one: one.candidate.plainness)
    named = [one for one in as_good if one.candidate.name != EVOLVED]
    return min([best, *named], key=lambda one: _burden(one.candidate))


def _burden(candidate: Candidate) -> tuple[int, bool]:
    """Return how many coefficients and inner numbers an effect has, and if it is nonlinear."""
    shape = shape_of(candidate)
    inside = 0 if shape is None else len(shape.values)
    return candidate.n_columns + inside, not candidate.is_straight


def _price(one: Contender, other: Contender) -> float:
    """Return the price (log error) of the nodes by which a grown term is longer than another."""
    longer = max(one.candidate.size - other.candidate.size, 0)
    return PRICE_PER_NODE_LOG * longer if one.candidate.name == EVOLVED else 0.0


def is_closer(one: Trial, other: Trial, least: float, level: float) -> bool:
    """Tell whether `one` has a log error less by `least`, on more stretches than by chance."""
    if not one.error < np.exp(-least) * other.error:  # also where both are zero
        return False
    if not np.isfinite(other.error):  # its runs diverge
        return True
    closer = _squares(other) - _squares(one)
    return bool(wilcoxon(closer, alternative="greater").pvalue <= level)


def _squares(trial: Trial) -> np.ndarray:
    """Return the squared error of each stretch, shape (n_stretches,)."""
    return np.asarray(np.sum((trial.miss / trial.scale) ** 2, axis=(1, 2)))
