"""Numbers inside effects, tuned by free runs; effects of several equations share one number.

Later each effect is compared with others while its partners stay as they are. So a shared number
has to be right before that: changed in one partner alone, it would make the runs worse.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from ...signals import Record
from ..effects.candidate import Candidate
from ..effects.partners import joined, partnerships
from ..evidence.findings import Finding, at_numbers, with_columns
from ..evidence.plainest import is_as_good
from ..fitting.trial import converged
from .contenders import steady_drift, trial_with
from .shape_tuning import Contender, tuned_by_runs
from .variants import Model


def shared_by_runs(
    model: Model, findings: Sequence[Finding], records: Sequence[Record]
) -> list[Finding]:
    """Return findings in which partners have the same numbers, tuned by free runs.

    Parameters
    ----------
    model : Model
        The declared model, with the memories and limits among the findings.
    findings : sequence of Finding
        What was found.
    records : sequence of Record
        Training records, before memories are applied.

    Returns
    -------
    list of Finding
        Partners keep different numbers where the runs are clearly closer with them.
    """
    places = partnerships([f.candidate for f in findings])
    return _with_numbers(places, model, findings, records)


def numbers_by_runs(
    model: Model, findings: Sequence[Finding], records: Sequence[Record]
) -> list[Finding]:
    """Return findings with the numbers inside their effects tuned by free runs.

    A filter rounds a kink, so in the derivative it seems to lie slightly elsewhere. The misses that
    this causes in the runs would be taken for one more effect.

    Parameters
    ----------
    model, findings, records
        As in `shared_by_runs`.

    Returns
    -------
    list of Finding
        Numbers are kept where the runs are clearly closer with them.
    """
    candidates = [f.candidate for f in findings]
    groups = partnerships(candidates)
    taken = {place for group in groups for place in group}
    alone = [[k] for k, c in enumerate(candidates) if c.shape is not None and k not in taken]
    return _with_numbers([*groups, *alone], model, findings, records)


def _with_numbers(
    groups: Sequence[Sequence[int]],
    model: Model,
    findings: Sequence[Finding],
    records: Sequence[Record],
) -> list[Finding]:
    """Tune the numbers of each group of findings beside all others."""
    kept = list(findings)
    for places in groups:
        rest = [f for k, f in enumerate(kept) if k not in places]
        without = replace(model, design=with_columns(model.design, rest))
        values = _shared([kept[place].candidate for place in places], without, records)
        if values is not None:
            for place in places:
                kept[place] = at_numbers(kept[place], values, model.design)
    return kept


def _shared(
    group: Sequence[Candidate], model: Model, records: Sequence[Record]
) -> tuple[float, ...] | None:
    """Return the numbers that partners share, in a model without them; None to keep their own."""
    unshared = joined(group)
    drift = steady_drift(model, [unshared], records)
    if drift is None:
        return None
    initial = dict.fromkeys(c.shape.values for c in group if c.shape is not None)
    together = [unshared.at(values) for values in initial]
    trials = [trial_with(model, [effect], drift) for effect in together]
    # The effects with their own numbers were fitted in other units of the errors.
    separate, *fitted = converged([drift.trial, *trials])
    tuned = tuned_by_runs(list(map(Contender, together, fitted)), model, drift)
    best = min(tuned, key=lambda effect: effect.error)
    if best.candidate.shape is None or not is_as_good(best.error, separate.error):
        return None
    return best.candidate.shape.values
