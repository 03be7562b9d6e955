"""Springs, of a position or of a stretch between two bodies, with their dead zones."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from ...terms import Sum, power
from .candidate import OFFSET, Candidate, CandidateMaker, Shape
from .kinks import beyond
from .names import (
    CUBIC_STIFFNESS,
    DEAD_ZONE,
    LINEAR_STIFFNESS,
    QUADRATIC_STIFFNESS,
    QUINTIC_STIFFNESS,
)
from .stops import stops

DEAD_ZONES = (0.03, 0.08, 0.2, 0.5)  # half widths, as shares of the reach


def springs(effect: CandidateMaker, q: Sum, reach: float) -> Iterator[Candidate]:
    """Yield springs of a position, of which the largest magnitude is given."""
    yield effect(LINEAR_STIFFNESS, q)
    yield effect(QUADRATIC_STIFFNESS, power(q, 2), parents=(OFFSET,))
    yield effect(CUBIC_STIFFNESS, power(q, 3))
    yield effect(QUINTIC_STIFFNESS, power(q, 5))
    for share in DEAD_ZONES:
        yield effect(DEAD_ZONE, shape=_half_width(share * reach, q))


def stretches(effect: CandidateMaker, stretch: Sum, reach: float) -> Iterator[Candidate]:
    """Yield springs between two bodies; the straight one is a coupling of their positions."""
    yield effect(QUADRATIC_STIFFNESS, power(stretch, 2), parents=(OFFSET,))
    yield effect(CUBIC_STIFFNESS, power(stretch, 3))
    for share in DEAD_ZONES:
        yield effect(DEAD_ZONE, shape=_half_width(share * reach, stretch))
    yield from stops(effect, stretch, reach, 0.0)


def _half_width(width: float, q: Sum) -> Shape:
    return Shape((width,), (partial(beyond, q),), meanings=("half width",))
