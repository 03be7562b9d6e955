"""Parameters that noise makes too small, as the motion that would tell them is no more than noise.

Where a controller rests, or its output is a weighted sum of the states, some combination of the
terms of an equation hardly varies. Noise in the states takes its place, which no derivative
follows, so the coefficients come out too small (regression dilution), with narrow intervals.

References
----------
Fuller, Measurement Error Models (1987), DOI 10.1002/9780470316665: attenuation by errors in the
regressors.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from scipy.linalg import eigh

from ...hidden_states.memory_equations import as_acting
from ...signals import Record
from ...terms import Sum
from ..given.rows import variables_of
from ..given.sticking import noise_of

if TYPE_CHECKING:
    from .report import LoopReport

__all__ = ["diluted"]

NOTABLE = 0.1  # of what varies of a combination of terms, that is noise: its weight is so much less
PART = 0.1  # of such a combination, that a term must be to take part in it
FAITHFUL = 50.0  # percent by which a run may miss: coefficients that it bore out are not diluted
RIDGE = 1e-12  # of the squares of terms, so that those which are alike do no harm


def diluted(report: LoopReport) -> list[str]:
    """Say of which parameters the values come out too small, or otherwise wrong.

    Parameters
    ----------
    report : LoopReport
        A declared model and what was found. Runs that follow the record bear its numbers out.

    Returns
    -------
    list of str
        A sentence for each equation with such parameters.
    """
    design = report.design
    if design.algebraic:
        return []
    records = [as_acting(report.equations, record)[1] for record in report.train]
    said = []
    for state in design.open_states:
        columns = [column for column in design.columns if column.parts[state].parts]
        if not columns or report.after.simulation_error[state] <= FAITHFUL:
            continue
        share, part = _noisiest([column.parts[state] for column in columns], records)
        names = [c.name for c, own in zip(columns, part, strict=True) if own > PART]
        if share > NOTABLE:
            said.append(_sentence(design.states[state], names, share))
    return said


def _noisiest(terms: Sequence[Sum], records: Sequence[Record]) -> tuple[float, np.ndarray]:
    """Return the share of noise in the combination of terms that holds most of it, and its parts.

    Parts are sizes of the terms in it, relative to the largest.
    """
    values = np.concatenate([_evaluated(terms, record.x, record) for record in records])
    noise = np.concatenate([_moved_by_noise(terms, record) for record in records])
    size = np.sqrt(np.mean(values**2, axis=0))
    if not np.isfinite(values).all() or not np.isfinite(noise).all() or not size.all():
        return 0.0, np.zeros(len(terms))
    gram, errors = (rows.T @ rows / len(values) for rows in (values / size, noise / size))
    shares, parts = eigh(errors, gram + RIDGE * np.eye(len(terms)))
    part = np.abs(parts[:, -1])
    return float(shares[-1]), part / part.max()


def _evaluated(terms: Sequence[Sum], x: np.ndarray, record: Record) -> np.ndarray:
    rows = variables_of(record).copy()
    rows[:, : x.shape[1]] = x
    with np.errstate(all="ignore"):
        return np.column_stack([term.evaluate(rows) for term in terms])


def _moved_by_noise(terms: Sequence[Sum], record: Record) -> np.ndarray:
    """Return by how much the noise of each state moves terms, one state below the other."""
    moved = []
    for state in range(record.n_states):
        away = np.zeros(record.n_states)
        away[state] = noise_of(record, state)
        up, down = (_evaluated(terms, record.x + way * away, record) for way in (1.0, -1.0))
        moved.append(0.5 * (up - down))
    return np.concatenate(moved)


def _sentence(state: str, names: Sequence[str], share: float) -> str:
    if len(names) == 1:
        what = f"The term of {names[0]} in d{state}/dt hardly varies along these records"
    else:
        listed = f"{', '.join(names[:-1])} and {names[-1]}"
        what = f"The terms of {listed} in d{state}/dt nearly cancel out along these records"
    return (
        f"{what}: {100 * min(share, 1.0):.0f} % of what is left is noise of the sensors, which "
        "makes their values wrong, mostly too small, by more than the intervals say. Move the "
        "machine further, or by a set point that varies."
    )
