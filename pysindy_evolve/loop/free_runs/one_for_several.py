"""One effect in place of several, where the later ones only correct the form of the first.

Where noise hides the form of an effect, a similar one is found first, and later terms without
meaning make up for the difference. None of them can be exchanged for the right effect alone, as the
others stand beside it. So each single effect is compared with the whole group, and replaces it if
its runs come as close to the record. Two effects with different names often are just that, so one
term replaces them only if its runs are clearly closer: sqrt(|v|) sgn(v) where Coulomb and Stribeck
friction were named.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...signals import Record
from ..effects.missing import beside
from ..effects.names import EVOLVED
from ..evidence.findings import Finding, is_needed, with_columns
from ..evidence.plainest import is_as_good
from ..evidence.scoring import PRICE_PER_NODE_LOG
from ..fitting.trial import converged
from .contenders import Pool, plainest, steady_drift, trial_with
from .shape_tuning import Contender
from .variants import Model

# Log of the squared error by which one term must be closer than two effects of different names; a
# lead of `MIN_GAIN_LOG` counts as none.
PAIR_LEAD_LOG = 0.07


def one_for_several(
    model: Model, findings: Sequence[Finding], pool: Pool, records: Sequence[Record]
) -> list[Finding]:
    """Return the findings, groups of them replaced by single effects that do as well.

    Parameters
    ----------
    model : Model
        The declared model, with the memories and limits among the findings.
    findings : sequence of Finding
        What was found, in order.
    pool : Pool
        Candidates that may replace a group.
    records : sequence of Record
        Training records, before memories are applied.

    Returns
    -------
    list of Finding
    """
    for group in _groups(findings):
        rest = [finding for finding in findings if finding not in group]
        without = replace(model, design=with_columns(model.design, rest))
        single = _single(without, group, pool, records)
        if single is not None:
            remaining = [single if f is group[0] else f for f in findings if f not in group[1:]]
            return one_for_several(model, remaining, pool, records)
    return list(findings)


def _groups(findings: Sequence[Finding]) -> list[list[Finding]]:
    """Return each effect with all later ones of its equation, and with each of them singly.

    A group counts if none of its effects is needed by the rest.
    """
    groups = []
    for place, first in enumerate(findings):
        later = [f for f in findings[place + 1 :] if f.candidate.state == first.candidate.state]
        groups += [[first, *later], *([first, one] for one in later)]
    several = {tuple(map(id, group)): group for group in groups if len(group) > 1}
    return [group for group in several.values() if _may_be_one(group, findings)]


def _may_be_one(group: Sequence[Finding], findings: Sequence[Finding]) -> bool:
    rest = [finding for finding in findings if finding not in group]
    return all(f.columns and not is_needed(f, rest) for f in group)


def _is_pair_of_names(group: Sequence[Finding]) -> bool:
    """Tell whether a group is two named effects, and no powers of a variable that form a curve.

    A grown term may be one of two parts of a curve, and three names seldom are three effects.
    """
    names = {finding.candidate.name for finding in group}
    return EVOLVED not in names and len(names) == len(group) == 2


def _single(
    without: Model, group: Sequence[Finding], pool: Pool, records: Sequence[Record]
) -> Finding | None:
    """Return the effect whose runs come as close to the record as those of a group, or None."""
    first, effects = group[0], [finding.candidate for finding in group]
    lead = PAIR_LEAD_LOG if _is_pair_of_names(group) else 0.0
    drift = steady_drift(without, effects, records)
    if drift is None or (lead and not pool.promises(effects, drift, lead)):
        return None
    (trial,) = converged([drift.trial])
    first_alone = Contender(first.candidate, trial_with(without, [first.candidate], drift))
    size = sum(effect.size for effect in effects)
    as_good = [
        one
        for one in pool.contenders(without, first_alone, drift, effects)
        if is_as_good(
            one.error * np.exp(lead + PRICE_PER_NODE_LOG * max(one.candidate.size - size, 0)),
            trial.error,
        )
    ]
    if not as_good:
        return None
    best = beside(plainest(as_good).candidate, without.design)
    return first.with_candidate(best, without.design)
