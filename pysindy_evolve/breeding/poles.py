"""Terms that become infinite between two samples: their denominator crosses zero."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..terms import Atom, Call, Sum

MIN_MAGNITUDE_SHARE = 0.1  # least magnitude of a denominator, as a share of its largest magnitude


def is_away(column: np.ndarray) -> bool:
    """Tell whether a column keeps its sign and stays away from zero."""
    least, largest = float(column.min()), float(column.max())
    near, far = sorted((abs(least), abs(largest)))
    return least * largest > 0.0 and near > MIN_MAGNITUDE_SHARE * far


def keeps_sign(column: np.ndarray) -> bool:
    """Tell whether a column does not cross zero; it may touch it."""
    return bool(column.min() * column.max() >= 0.0)


def has_pole(
    expression: Sum, rows: np.ndarray, may_divide: Callable[[np.ndarray], bool] = is_away
) -> bool:
    """Tell whether a denominator within an expression crosses zero, or comes close.

    The few values near a pole would only fit the noise there. A sum of squares never crosses zero,
    as in 1 / (c^2 + v^2), nor do terms of one sign on these rows, as in 1 / (c + S + S^2). So the
    square root of such a sum is tested instead.

    Parameters
    ----------
    expression : Sum
        The term.
    rows : ndarray of shape (n, n_variables + 1)
        Variables of a record.
    may_divide : callable
        Tells whether a column may be a denominator.

    Returns
    -------
    bool
    """
    with np.errstate(all="ignore"):  # a column with NaN may not divide
        return any(
            (exponent < 0 and not may_divide(_length(atom, rows)))
            or _holds_pole(atom, rows, may_divide)
            for _, term in expression.parts
            for atom, exponent in term.factors
        )


def _length(atom: Atom, rows: np.ndarray) -> np.ndarray:
    """Return the values of a denominator; of a positive sum with a square in it, its root."""
    values = atom.evaluate(rows)
    parts = atom.parts if isinstance(atom, Sum) else ()
    has_square = any(n % 2 == 0 for _, term in parts for _, n in term.factors)
    positive = (bool((c * term.evaluate(rows) >= 0.0).all()) for c, term in parts)
    return np.sqrt(values) if has_square and all(positive) else values


def _holds_pole(atom: Atom, rows: np.ndarray, may_divide: Callable[[np.ndarray], bool]) -> bool:
    inside = atom.args if isinstance(atom, Call) else (atom,) if isinstance(atom, Sum) else ()
    return any(has_pole(part, rows, may_divide) for part in inside)
