"""Whether columns are combinations of others as expressions, not only on the rows of a record.

Beside a spring between two bodies, k (q2 - q1), a spring from q2 to the ground and a pull by q1 are
the same model, written in two ways: no record can tell them apart.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..given.design import Column

RANK_TOLERANCE = 1e-9  # singular values of unit rows: smaller ones count as zero
N_PLACES = 200  # at which expressions are compared


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


def span_in(
    columns: Sequence[Column], others: Sequence[Column], low: np.ndarray, high: np.ndarray
) -> bool:
    """Tell whether columns span others at places drawn at random.

    So I V / (V + c) is a combination of I and I / (V + c), though no product is the same.

    Parameters
    ----------
    columns, others : sequence of Column
        As in `span`.
    low, high : ndarray of shape (n_variables,)
        Ranges of the variables, from which the places are drawn.

    Returns
    -------
    bool
        False if a column has no value at one of the places.
    """
    places = np.random.default_rng(0).uniform(low, high, (N_PLACES, len(low)))
    with np.errstate(all="ignore"):
        rows = np.array([one.evaluate(places).ravel() for one in (*columns, *others)])
    if not np.isfinite(rows).all():
        return False
    size = np.linalg.norm(rows, axis=1, keepdims=True)
    unit = rows / np.where(size > 0.0, size, 1.0)
    return _rank(unit) == _rank(unit[: len(columns)])


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
