"""The numbers of hidden states, such as a hysteresis or a relaxation, tuned again.

Effects found later change these numbers, so they are tuned again in each step.

A filter rounds off the reversals of a motion, and so distorts what a friction remembers. Free runs
contain no filter. The hidden state of a run starts where the measured states put it, and all starts
are fitted as well (multiple shooting).
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
from ..evidence.scoring import EXTRA_LEAD_LOG, tuned
from ..fitting.fit import refit
from ..fitting.shooting import fit_to_runs, gains_of_runs
from ..fitting.unfolding import (
    paths_of,
    records_with_hidden_states,
    retuned,
    square_left,
    with_hidden_states,
)
from ..given.design import Design
from ..given.segments import Segments
from .revise import exchange

N_ROUNDS = 2
# Hidden states without the jumps of a friction; a filter of the record may look like them.
SMOOTH = (RELAXING, WEN_SPRING, FLEXIBLE_MODE)


def with_numbers(declared: Design, findings: Sequence[Finding], part: Segments) -> list[Finding]:
    """Return findings with hidden states tuned and the other effects exchanged, in turn.

    Parameters
    ----------
    declared : Design
        The declared model.
    findings : sequence of Finding
        What was found.
    part : Segments
        Pieces of the training records.

    Returns
    -------
    list of Finding
        Unchanged for an algebraic target, or without hidden states.
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
    """Return findings with the numbers of their hidden states tuned by free runs.

    Parameters
    ----------
    declared : Design
        The declared model.
    findings : sequence of Finding
        What was found.
    records : sequence of Record
        Training records, with inputs as they act.

    Returns
    -------
    list of Finding
        Unchanged if the runs cannot follow the records, or do not improve.
    """
    design = with_findings(declared, findings)
    paths = paths_of(design)
    weights = [kind_of(path).weights(path) for path in paths]
    initial = np.concatenate([refit(design, records, "derivative"), *weights])
    ends = len(design.columns) + np.cumsum([0, *(len(of_path) for of_path in weights)])[:-1]

    def at(coef: np.ndarray) -> list[Finding]:
        return _retuned(findings, paths, np.split(coef, ends)[1:], declared)

    def loss(coef: np.ndarray) -> float:
        tuned_design = with_findings(declared, at(coef))
        return square_left(tuned_design, records, coef[: len(design.columns)])

    many, shown = with_hidden_states(design, free=True), records_with_hidden_states(design, records)
    coef = fit_to_runs(many, initial, shown, loss)
    return list(findings) if coef is None else at(coef)


def filter_like_paths(design: Design) -> tuple[Call, ...]:
    """Return the hidden states of a design that may only imitate a filter."""
    return tuple(path for path in design.paths if path.operator in SMOOTH)


def needed_by_runs(
    declared: Design, findings: Sequence[Finding], records: Sequence[Record]
) -> list[Finding]:
    """Return findings without relaxations and springs where free runs do as well without them.

    A smoothed derivative, or colored noise, looks like a memory too. Free runs use no derivative,
    so such a memory does not improve them, or makes the derivative worse.

    Parameters
    ----------
    declared : Design
        The declared model.
    findings : sequence of Finding
        What was found.
    records : sequence of Record
        Training records, with inputs as they act.

    Returns
    -------
    list of Finding
    """
    kept, longest = list(findings), max(records, key=len)
    for finding in findings:
        rest = excluding(kept, finding)
        few, many = (with_findings(declared, effects) for effects in (rest, kept))
        new = set(filter_like_paths(many)) - set(filter_like_paths(few))
        sound = all(is_sound(path, longest) for path in new)
        if new and not (
            sound and _opposes(finding, many, records) and _better_runs(few, many, records)
        ):
            kept = rest
    return kept


def _opposes(finding: Finding, design: Design, records: Sequence[Record]) -> bool:
    """Tell whether an effect takes energy (its coefficient is negative); true if algebraic."""
    coef = refit(design, records, "derivative")[design.columns.index(finding.columns[0])]
    return design.algebraic or bool(coef < 0.0)


def _better_runs(few: Design, many: Design, records: Sequence[Record]) -> bool:
    if few.algebraic:  # there are no free runs
        return True
    runs, derivative = gains_of_runs(few, many, records)
    return runs >= EXTRA_LEAD_LOG and derivative > 0.0


def _retuned(
    findings: Sequence[Finding],
    paths: Sequence[Call],
    weights: Sequence[np.ndarray],
    design: Design,
) -> list[Finding]:
    """Return findings with new weights of their hidden states."""
    kept = list(findings)
    for path, new in zip(paths, weights, strict=True):
        changed = [retuned(finding.candidate, path, new) for finding in kept]
        kept = [
            f if c is f.candidate else f.with_candidate(c, design)
            for f, c in zip(kept, changed, strict=True)
        ]
    return kept
