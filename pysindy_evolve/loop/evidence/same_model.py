"""Whether columns are combinations of others as expressions, not only on the rows of a record.

Beside a spring between two bodies, k (q2 - q1), a spring from q2 to the ground and a pull by q1 are
the same model, written in two ways: no record can tell them apart.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..given.design import Column

RANK_TOLERANCE = 1e-9  # singular values of unit rows: smaller ones count as zero


def span(columns: Sequence[Column], others: Sequence[Column]) -> bool:
    """Tell whether columns span others, so that these are linear combinations of them.

    Parameters
    ----------
    columns : sequence of Column
        Columns of a model.
    others : sequence of Column
        Columns that may be combinations of them.

    Returns
    -------
    bool
    """
    rows = _numbers([*columns, *others])
    return _rank(rows) == _rank(rows[: len(columns)])


def _rank(rows: np.ndarray) -> int:
    return int(np.linalg.matrix_rank(rows, tol=RANK_TOLERANCE))


def _numbers(columns: Sequence[Column]) -> np.ndarray:
    """Return the coefficient of each product in each equation, a row of unit size per column."""
    rows = [
        {(state, term): c for state, part in enumerate(column.parts) for c, term in part.parts}
        for column in columns
    ]
    places = list(dict.fromkeys(place for row in rows for place in row))
    numbers = np.array([[row.get(place, 0.0) for place in places] for row in rows])
    size = np.linalg.norm(numbers, axis=1, keepdims=True)
    return np.asarray(numbers / np.where(size > 0.0, size, 1.0))
