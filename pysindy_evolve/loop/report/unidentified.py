"""Declared parameters that the records do not tell: terms that are alike there, or zero."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.linalg import null_space
from scipy.sparse.csgraph import connected_components

from ...signals import Record
from ..given.design import Design
from ..given.rows import variables_of

__all__ = ["unidentified", "unidentified_sentences"]

ALIKE = 1e-7  # of the size of terms, that a combination of them may leave
PART = 1e-3  # of such a combination, that a term must be to take part in it


def unidentified(design: Design, records: Sequence[Record]) -> list[tuple[str, ...]]:
    """Return groups of parameters of which the records tell no single one.

    Parameters
    ----------
    design : Design
        The declared model, with p columns.
    records : sequence of Record
        Training records.

    Returns
    -------
    list of tuple of str
        Names: one alone where its term is zero on all rows, several where other values of all of
        them fit as well.
    """
    if not design.columns:
        return []
    variables = np.concatenate([variables_of(record) for record in records])
    terms = np.column_stack([column.evaluate(variables).ravel() for column in design.columns])
    size = np.linalg.norm(terms, axis=0)
    idle = size == 0.0
    free = null_space(np.linalg.qr(terms / np.where(idle, 1.0, size), mode="r"), rcond=ALIKE)
    together = np.abs(free @ free.T) > PART
    _, groups = connected_components(together)
    lost = np.flatnonzero(together.diagonal())
    names = [column.name for column in design.columns]
    return [
        tuple(names[k] for k in lost if groups[k] == group)
        for group in dict.fromkeys(groups[lost].tolist())
    ]


def unidentified_sentences(design: Design, records: Sequence[Record]) -> list[str]:
    """Say which declared parameters the records do not tell.

    Parameters
    ----------
    design, records
        As in `unidentified`.

    Returns
    -------
    list of str
        Sentences.
    """
    said = []
    for *others, last in unidentified(design, records):
        if others:
            said.append(
                f"The records do not tell {', '.join(others)} from {last}: their terms are alike "
                "there, so that other values fit as well."
            )
        else:
            said.append(
                f"The records say nothing of {last}: its term is zero on all of them. "
                "Excite it, or give its value as known."
            )
    return said
