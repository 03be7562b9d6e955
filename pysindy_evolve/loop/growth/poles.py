"""Terms that are infinite somewhere between the samples: what is below the line crosses zero."""

from __future__ import annotations

import numpy as np

from ...terms import Atom, Call, Sum

__all__ = ["AWAY", "has_pole", "is_away"]

AWAY = 0.1  # of its largest magnitude, by which what is below the line keeps away from zero


def is_away(column: np.ndarray) -> bool:
    """Tell whether a column keeps its sign, and its distance from zero."""
    least, largest = float(column.min()), float(column.max())
    near, far = sorted((abs(least), abs(largest)))
    return least * largest > 0.0 and near > AWAY * far


def has_pole(expression: Sum, rows: np.ndarray) -> bool:
    """Tell whether a term divides by what crosses zero, or comes close.

    Its few values near the pole would say whatever the noise there says.

    Parameters
    ----------
    expression : Sum
        The term.
    rows : ndarray of shape (n, n_variables + 1)
        Variables of a record, time last.

    Returns
    -------
    bool
    """
    with np.errstate(all="ignore"):  # what has no value is not away from zero either
        return any(
            (exponent < 0 and not is_away(atom.evaluate(rows))) or _holds_pole(atom, rows)
            for _, term in expression.parts
            for atom, exponent in term.factors
        )


def _holds_pole(atom: Atom, rows: np.ndarray) -> bool:
    inside = atom.args if isinstance(atom, Call) else (atom,) if isinstance(atom, Sum) else ()
    return any(has_pole(part, rows) for part in inside)
