"""A drift that is no more than a sensor, or a force, that wanders.

What is the sum of many small random steps looks like a trend, and fits one better the longer the
record is (Granger and Newbold, J. Econometrics 2 (1974), DOI 10.1016/0304-4076(74)90034-7). So what
is left without a drift is taken for such walks with noise upon it, the more the likelier they are,
and the drift must be more than that.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.special import softmax
from scipy.stats import t as student

from ...checks import TINY
from ...equations import Equations
from ...signals import Record
from ..evidence.findings import Finding, is_needed
from ..facts.effect import Effect
from ..fitting.past import derivative_residual
from ..fitting.random_force import whitening
from ..given.rows import variables_of

MAX_MEANS_PER_RECORD = 64  # of a record, means over equal times: what wanders is slow
MAX_VARIANCE_SHARE_WITHIN = 0.1  # of an effect's variance, at most, is within these times


def last_wandering(
    findings: Sequence[Finding],
    effects: Sequence[Effect],
    corrected: Equations,
    records: Sequence[Record],
    significance: float,
) -> Finding | None:
    """Return the last effect of the time, a slow one, that a random walk shows as well.

    Parameters
    ----------
    findings : sequence of Finding
        What was found.
    effects : sequence of Effect
        The same with their coefficients.
    corrected : Equations
        The model with all of them.
    records : sequence of Record
        Training records.
    significance : float
        With a larger chance, a walk shows as much of it.

    Returns
    -------
    Finding or None
    """
    for finding, effect in reversed(list(zip(findings, effects, strict=True))):
        if not _uses_time(finding, records[0]) or is_needed(finding, findings):
            continue
        pieces = [_pieces(finding, effect.coefficients, corrected, record) for record in records]
        if all(map(_is_slow, pieces)) and _chance_of_walk(pieces) > significance:
            return finding
    return None


def _uses_time(finding: Finding, record: Record) -> bool:
    """Tell whether an effect is a term that the time is in."""
    time, candidate = record.n_states + record.n_inputs, finding.candidate
    return bool(finding.columns) and time in candidate.variables and not candidate.is_exchange


def _pieces(
    finding: Finding, coef: np.ndarray, corrected: Equations, record: Record
) -> list[np.ndarray]:
    """Return pieces of a record, with what an effect does, and what is left without it."""
    variables, terms = variables_of(record), finding.candidate.terms
    done = np.column_stack([term.evaluate(variables) for term in terms]) @ coef[: len(terms)]
    left = derivative_residual(corrected, record)[:, finding.candidate.state] + done
    return np.array_split(np.column_stack([done, left]), min(MAX_MEANS_PER_RECORD, len(record)))


def _is_slow(pieces: Sequence[np.ndarray]) -> bool:
    """Tell whether an effect hardly changes within each of the pieces."""
    within = np.mean([piece[:, 0].var() for piece in pieces])
    return bool(within < MAX_VARIANCE_SHARE_WITHIN * np.concatenate(pieces)[:, 0].var())


def _chance_of_walk(records: Sequence[Sequence[np.ndarray]]) -> float:
    """Return the chance that a random walk with noise follows an effect as closely.

    It is that of each walk, weighed by its restricted likelihood. The likeliest strength of a faint
    walk is often zero, and with it alone any trend would look significant.
    """
    grams, logdets, n_free = np.zeros((2, 2)), np.zeros(1), -1
    for pieces in records:
        rows = np.array([piece.mean(axis=0) for piece in pieces])
        weights = whitening(len(rows), 1)
        grams, logdets = grams + weights.grams(rows), logdets + weights.logdets
        n_free += len(rows) - 1
    size = np.maximum(grams[:, 0, 0], TINY)
    rest = np.maximum(grams[:, 1, 1] - grams[:, 0, 1] ** 2 / size, TINY)
    chances = 2.0 * student.sf(np.abs(grams[:, 0, 1]) / np.sqrt(size * rest / n_free), n_free)
    likely = softmax(-0.5 * (n_free * np.log(rest) + logdets + np.log(size)))
    return float(likely @ chances)
