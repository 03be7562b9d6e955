"""Declared parameters that the records do not determine: their terms are collinear, or zero."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.linalg import null_space
from scipy.sparse.csgraph import connected_components

from ...signals import Record
from ..given.design import Design
from ..given.rows import rows_of

COLLINEAR = 1e-7  # singular value of the normalized terms, relative to the largest, taken as zero
PARTICIPATES = 1e-3  # entry of the projector on their null space from which terms are coupled


def unidentified(design: Design, records: Sequence[Record]) -> list[tuple[str, ...]]:
    """Return groups of parameters that the records do not determine.

    Parameters
    ----------
    design : Design
        The declared model, with p columns.
    records : sequence of Record
        Training records.

    Returns
    -------
    list of tuple of str
        Names in each group: a single one if its term is zero on all rows, several if a combination
        of their terms vanishes, so that other values of them fit as well.
    """
    if not design.columns:
        return []
    variables = rows_of(records)
    terms = np.column_stack([column.evaluate(variables).ravel() for column in design.columns])
    norm = np.linalg.norm(terms, axis=0)
    is_zero = norm == 0.0
    null = null_space(np.linalg.qr(terms / np.where(is_zero, 1.0, norm), mode="r"), rcond=COLLINEAR)
    coupled = np.abs(null @ null.T) > PARTICIPATES
    _, groups = connected_components(coupled)
    undetermined = np.flatnonzero(coupled.diagonal())
    names = [column.name for column in design.columns]
    return [
        tuple(names[k] for k in undetermined if groups[k] == group)
        for group in dict.fromkeys(groups[undetermined].tolist())
    ]
