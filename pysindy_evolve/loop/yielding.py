"""The numbers of a hysteresis in an equation of motion, tuned again.

What is found beside a hysteresis changes its numbers, so they are tuned again in each step.

A filter rounds off the turns of a motion, and what a friction remembers of them. A model that runs
by itself has no filter in it. Its runs begin with the hysteresis where the measured motion puts it,
and where each of them begins is fitted as well (multiple shooting).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..boucwen import numbers_of
from ..signals import Record
from ..terms import Call
from .by_runs import with_findings
from .design import Design
from .fit import derivative_square, refit
from .revise import exchange
from .scoring import columns_of, tuned
from .segments import Segments
from .shooting import met
from .step import Finding
from .unfolding import paths_of, retuned, unfolded, with_paths

__all__ = ["with_numbers", "with_numbers_of_runs"]

N_ROUNDS = 2


def with_numbers(declared: Design, findings: Sequence[Finding], part: Segments) -> list[Finding]:
    """Return findings whose hystereses are tuned beside all the others, and these beside them.

    Parameters
    ----------
    declared : Design
        The model at the start.
    findings : sequence of Finding
        What was found.
    part : Segments
        Pieces of the training records.

    Returns
    -------
    list of Finding
    """
    kept = list(findings)
    if not paths_of(with_findings(declared, kept)):
        return kept
    for _ in range(N_ROUNDS):
        for place, finding in enumerate(kept):
            rest = with_findings(declared, [f for f in kept if f is not finding])
            if paths_of(rest) != paths_of(with_findings(declared, kept)):
                candidate = tuned(finding.candidate, rest, part)
                columns = columns_of(candidate, declared)
                kept[place] = replace(finding, candidate=candidate, columns=columns)
        kept = exchange(declared, kept, part, latest=True)
    return kept


def with_numbers_of_runs(
    declared: Design, findings: Sequence[Finding], records: Sequence[Record]
) -> list[Finding]:
    """Return findings whose hystereses have the numbers that free runs give them.

    Parameters
    ----------
    declared : Design
        The model at the start.
    findings : sequence of Finding
        What was found.
    records : sequence of Record
        Training records, with what acts.

    Returns
    -------
    list of Finding
        The same ones where the runs cannot follow the records, or better nothing.
    """
    design = with_findings(declared, findings)
    paths = paths_of(design)
    known = [(1.0 / length, k / length) for length, k in map(numbers_of, paths)]
    begun = np.append(refit(design, records, "derivative"), known)

    def at(coef: np.ndarray) -> list[Finding]:
        return _retuned(findings, paths, coef[len(design.columns) :].reshape(-1, 2), declared)

    def loss(coef: np.ndarray) -> float:
        there = with_findings(declared, at(coef))
        return derivative_square(there, records, coef[: len(design.columns)])

    coef = met(unfolded(design, free=True), begun, with_paths(design, records), loss)
    return list(findings) if coef is None else at(coef)


def _retuned(
    findings: Sequence[Finding], paths: Sequence[Call], numbers: np.ndarray, design: Design
) -> list[Finding]:
    """Return findings with other numbers, shape (n_paths, 2), in their hystereses."""
    kept = list(findings)
    for path, own in zip(paths, numbers, strict=True):
        changed = [retuned(finding.candidate, path, own) for finding in kept]
        kept = [
            f if c is f.candidate else replace(f, candidate=c, columns=columns_of(c, design))
            for f, c in zip(kept, changed, strict=True)
        ]
    return kept
