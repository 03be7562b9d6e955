"""Unwraps angles that jump back after a full turn."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..signals.spectral import Array
from ..signals.wrapping import BEYOND

__all__ = ["check_angles", "unwrapped"]


def check_angles(turns: Sequence[tuple[str, float]], known: Sequence[str]) -> None:
    """Raise if an angle to unwrap is not among the columns, or is given twice."""
    angles = [angle for angle, _ in turns]
    for angle in angles:
        if angle not in known:
            raise ValueError(
                f"--unwrap must name a measured state or an input; got {angle!r}. "
                f"Choose from {', '.join(known)}."
            )
        if angles.count(angle) > 1:
            raise ValueError(
                f"--unwrap must be given once for each angle; got {angle!r} "
                f"{angles.count(angle)} times. Keep the one whose turn is right."
            )


def unwrapped(column: Array, angle: str, turn: float) -> Array:
    """Return a column without its jumps after each turn; raise if its range exceeds a turn."""
    low, high = float(column.min()), float(column.max())
    if high - low > (1.0 + BEYOND) * turn:
        raise ValueError(
            f"--unwrap must name an angle that stays within its turn; got {angle!r} from {low:g} "
            f"to {high:g} with a turn of {turn:g}. Correct the turn, 360 for degrees and 6.283185 "
            "for radians, or leave out --unwrap if the angle goes on already."
        )
    return np.asarray(np.unwrap(column, period=turn))
