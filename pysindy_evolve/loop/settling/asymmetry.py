"""Friction that differs with the direction is an offset and a friction: one force in two names.

-a for v > 0 and b for v < 0 is -(a + b)/2 sgn(v) - (a - b)/2. No record can tell the two, so where
both parts were found the other name belongs to them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from ..effects.names import ASYMMETRIC_FRICTION, CONSTANT_OFFSET, COULOMB_FRICTION
from ..evidence.findings import Finding

__all__ = ["with_asymmetry"]


def with_asymmetry(findings: Sequence[Finding]) -> list[Finding]:
    """Return findings in which friction beside an offset knows its other name.

    Parameters
    ----------
    findings : sequence of Finding
        What was found.

    Returns
    -------
    list of Finding
    """
    states = {
        name: {f.candidate.state for f in findings if f.candidate.name == name}
        for name in (COULOMB_FRICTION, CONSTANT_OFFSET, ASYMMETRIC_FRICTION)
    }
    there = (states[COULOMB_FRICTION] & states[CONSTANT_OFFSET]) - states[ASYMMETRIC_FRICTION]
    return [
        replace(f, together=(ASYMMETRIC_FRICTION,))
        if f.candidate.state in there and f.candidate.name in (COULOMB_FRICTION, CONSTANT_OFFSET)
        else f
        for f in findings
    ]
