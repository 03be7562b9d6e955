"""The numbers of what remembers a state, a hysteresis or a relaxation, tuned again.

What is found beside it changes its numbers, so they are tuned again in each step.

A filter rounds off the turns of a motion, and what a friction remembers of them. A model that runs
by itself has no filter in it. Its runs begin with the hidden state where the measured ones put it,
and where each of them begins is fitted as well (multiple shooting).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...hidden_states.flexible_mode import FLEXIBLE_MODE
from ...hidden_states.path_states import kind_of
from ...hidden_states.relaxing import RELAXING
from ...hidden_states.wen_spring import WEN_SPRING
from ...signals import Record
from ...terms import Call
from ..effects.followers import is_sound
from ..evidence.findings import Finding, excluding, with_findings
from ..evidence.scoring import LEAD, tuned
from ..fitting.fit import refit
from ..fitting.shooting import fit_to_runs, gains_of_runs
from ..fitting.unfolding import paths_of, retuned, square_left, unfolded, with_paths
from ..given.design import Design
from ..given.segments import Segments
from .revise import exchange

__all__ = ["needed_by_runs", "smooth_in", "with_numbers", "with_numbers_of_runs"]

N_ROUNDS = 2
# Without the jumps of a friction: a filter may look like them.
SMOOTH = (RELAXING, WEN_SPRING, FLEXIBLE_MODE)


def with_numbers(declared: Design, findings: Sequence[Finding], part: Segments) -> list[Finding]:
    """Return findings whose hidden states are tuned beside all the others, and these beside them.

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
        The same ones of an algebraic target.
    """
    kept = list(findings)
    if not paths_of(with_findings(declared, kept)):
        return kept
    for _ in range(N_ROUNDS):
        for place, finding in enumerate(kept):
            rest = with_findings(declared, excluding(kept, finding))
            if paths_of(rest) != paths_of(with_findings(declared, kept)):
                candidate = tuned(finding.candidate, rest, part)
                kept[place] = finding.with_candidate(candidate, declared)
        kept = exchange(declared, kept, part, latest=True)
    return kept


def with_numbers_of_runs(
    declared: Design, findings: Sequence[Finding], records: Sequence[Record]
) -> list[Finding]:
    """Return findings whose hidden states have the numbers that free runs give them.

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
    known = [kind_of(path).weights(path) for path in paths]
    begun = np.concatenate([refit(design, records, "derivative"), *known])
    ends = len(design.columns) + np.cumsum([0, *(len(own) for own in known)])[:-1]

    def at(coef: np.ndarray) -> list[Finding]:
        return _retuned(findings, paths, np.split(coef, ends)[1:], declared)

    def loss(coef: np.ndarray) -> float:
        there = with_findings(declared, at(coef))
        return square_left(there, records, coef[: len(design.columns)])

    coef = fit_to_runs(unfolded(design, free=True), begun, with_paths(design, records), loss)
    return list(findings) if coef is None else at(coef)


def smooth_in(design: Design) -> tuple[Call, ...]:
    """Return what remembers in a design and may be no more than a filter."""
    return tuple(path for path in design.paths if path.operator in SMOOTH)


def needed_by_runs(
    declared: Design, findings: Sequence[Finding], records: Sequence[Record]
) -> list[Finding]:
    """Return findings without relaxations and springs where free runs do as well without them.

    A derivative that somebody smoothed, or noise that is not white, looks remembered as well. Of
    that nothing is left in runs, which need no derivative; or what betters them worsens it.

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
    """
    kept, longest = list(findings), max(records, key=len)
    for finding in findings:
        rest = excluding(kept, finding)
        few, many = (with_findings(declared, those) for those in (rest, kept))
        new = set(smooth_in(many)) - set(smooth_in(few))
        sound = all(is_sound(path, longest) for path in new)
        if new and not (
            sound and _opposes(finding, many, records) and _better_runs(few, many, records)
        ):
            kept = rest
    return kept


def _opposes(finding: Finding, design: Design, records: Sequence[Record]) -> bool:
    """Tell whether an effect of an equation of motion takes energy: its coefficient is negative."""
    coef = refit(design, records, "derivative")[design.columns.index(finding.columns[0])]
    return design.algebraic or bool(coef < 0.0)


def _better_runs(few: Design, many: Design, records: Sequence[Record]) -> bool:
    if few.algebraic:  # nothing runs
        return True
    runs, derivative = gains_of_runs(few, many, records)
    return runs >= LEAD and derivative > 0.0


def _retuned(
    findings: Sequence[Finding],
    paths: Sequence[Call],
    weights: Sequence[np.ndarray],
    design: Design,
) -> list[Finding]:
    """Return findings with other weights in what remembers."""
    kept = list(findings)
    for path, own in zip(paths, weights, strict=True):
        changed = [retuned(finding.candidate, path, own) for finding in kept]
        kept = [
            f if c is f.candidate else f.with_candidate(c, design)
            for f, c in zip(kept, changed, strict=True)
        ]
    return kept
